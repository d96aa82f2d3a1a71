"""Threads that do their work again and again while the service runs."""

from __future__ import annotations

import logging
import threading

PERIOD = 1.0  # [s] between two pieces of work
CLOSING_TIME = 5.0  # [s] at most for the last one to end
_log = logging.getLogger(__name__)


class RepeatingThread(threading.Thread):
    """A thread that works until it is closed; what fails is logged and tried again."""

    def __init__(self, name: str) -> None:
        super().__init__(name=name, daemon=True)
        self._ending, self._wake = threading.Event(), threading.Event()

    def close(self) -> None:
        """End the thread."""
        self._ending.set()
        self.wake()
        if self.is_alive():
            self.join(CLOSING_TIME)

    def wake(self) -> None:
        """Have the thread work at once."""
        self._wake.set()

    def work(self) -> bool:
        """Do a piece of work; return whether the next one follows at once."""
        raise NotImplementedError

    def run(self) -> None:
        """Work until the end."""
        while not self._ending.is_set():
            try:
                if self.work():
                    continue
            except Exception:  # noqa: BLE001  # the database may be away, for instance
                _log.exception("the thread %r failed; it tries again", self.name)
            self._wake.wait(PERIOD)
            self._wake.clear()
