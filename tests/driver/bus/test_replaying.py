"""Frames of a log sent again: at their pace, without the adapter's error frames."""

import pytest

from omnimate.driver.bus.bus import open_bus
from omnimate.driver.bus.replaying import send_frames
from omnimate.files.logs.frames import ERROR, EXTENDED, REMOTE, Frame

FRAMES = (
    Frame(10.0, 0x080, b""),
    Frame(10.5, 0x181, b"\x01\x02"),
    Frame(10.6, 0x000, b"", ERROR),
    Frame(12.0, 0x12345, b"\x03", EXTENDED),
    Frame(12.0, 0x701, b"", REMOTE),
)


class Clock:
    """Time that passes only while somebody sleeps."""

    def __init__(self):
        self.now, self.waits = 0.0, []

    def __call__(self):
        return self.now

    def sleep(self, seconds):
        self.waits.append(seconds)
        self.now += seconds


@pytest.mark.parametrize(("pace", "waits"), [(1.0, [0.5, 1.5]), (2.0, [0.25, 0.75]), (0.0, [])])
def test_frames_keep_the_distances_that_they_were_recorded_with(pace, waits):
    clock = Clock()
    with open_bus("virtual://replaying") as bus:
        send_frames(FRAMES, "virtual://replaying", pace, clock=clock, sleep=clock.sleep)
        sent = [bus.recv(1.0) for _ in range(4)]
        assert bus.recv(0.0) is None
    assert clock.waits == waits
    assert [message.arbitration_id for message in sent] == [0x080, 0x181, 0x12345, 0x701]
    assert [message.is_extended_id for message in sent] == [False, False, True, False]
    assert [message.is_remote_frame for message in sent] == [False, False, False, True]
    assert bytes(sent[1].data) == b"\x01\x02"
