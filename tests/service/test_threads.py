"""Threads that repeat their work: what failed is tried again, and what waits is done at once."""

import logging

from omnimate.service.threads import RepeatingThread


class Working(RepeatingThread):
    """A thread whose pieces of work end as given; after the last one it ends itself."""

    def __init__(self, ends):
        super().__init__("working")
        self.left = ends

    def work(self):
        end = self.left.pop(0)
        if not self.left:
            self._ending.set()
        self.wake()
        if isinstance(end, Exception):
            raise end
        return end


def test_a_thread_goes_on_after_an_error_and_logs_it(caplog):
    thread = Working([ValueError("wrong"), True, False, OSError("away"), False])
    with caplog.at_level(logging.ERROR):
        thread.start()
        thread.join(60.0)
    assert (thread.is_alive(), thread.left) == (False, [])
    assert [str(record.exc_info[1]) for record in caplog.records] == ["wrong", "away"]


def test_a_thread_that_was_closed_before_its_start_does_nothing():
    thread = Working([False])
    thread.close()
    thread.start()
    thread.join(60.0)
    assert thread.left == [False]
