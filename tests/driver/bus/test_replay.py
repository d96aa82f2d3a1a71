"""A log as a bus: frames come at their pace with the times of the log, and nothing can be sent."""

from contextlib import nullcontext
from types import SimpleNamespace

import can
import pytest

from omnimate.driver.bus import replay
from omnimate.driver.bus.bus import open_bus
from omnimate.driver.bus.replay import LogBus, send_frames
from omnimate.driver.errors import BusError, BusLost
from omnimate.files.logs.frames import ERROR, EXTENDED, REMOTE, Frame

FRAMES = [Frame(100.0, 0x181, b"a"), Frame(100.5, 0x182, b"b"), Frame(102.0, 0x183, b"c")]
ALL_KINDS = (
    Frame(10.0, 0x080, b""),
    Frame(10.5, 0x181, b"\x01\x02"),
    Frame(10.6, 0x000, b"", ERROR),
    Frame(12.0, 0x12345, b"\x03", EXTENDED),
    Frame(12.0, 0x701, b"", REMOTE),
)


@pytest.fixture
def clock(monkeypatch):
    """Host time that passes only while the bus sleeps."""
    host = SimpleNamespace(now=7.0, waits=[])
    host.monotonic = lambda: host.now

    def sleep(seconds):
        host.waits.append(seconds)
        host.now += seconds

    host.sleep = sleep
    monkeypatch.setattr(replay, "time", host)
    return host


@pytest.mark.parametrize("pace", [1.0, 4.0])
def test_frames_come_when_their_time_has_come(clock, pace):
    bus = LogBus(iter(FRAMES), pace)
    heard = []
    while not bus.ended:
        message = bus._recv_internal(0.1)[0]
        if message is not None:
            heard.append((round((clock.now - 7.0) * pace, 6), message.timestamp, bytes(message.data)))
            assert bus.now() == pytest.approx(message.timestamp)
    assert heard == [(0.0, 100.0, b"a"), (0.5, 100.5, b"b"), (2.0, 102.0, b"c")]
    bus.shutdown()


def test_the_time_does_not_pass_a_frame_that_is_received_late(clock):
    bus = LogBus(iter(FRAMES))
    bus._recv_internal(0.1)
    clock.now += 1.0
    assert bus.now() == FRAMES[1].time
    bus._recv_internal(0.1)
    assert bus.now() == 101.0
    bus.shutdown()


def test_after_the_end_there_is_silence(clock):
    bus = LogBus(iter(FRAMES[:1]))
    assert [bus._recv_internal(0.1)[0] is None for _ in range(3)] == [False, True, True]
    bus.shutdown()


def test_nothing_can_be_sent():
    bus = LogBus(iter(FRAMES))
    with pytest.raises(BusError, match="only replayed"):
        bus.send(can.Message(arbitration_id=0x80))
    bus.shutdown()


@pytest.mark.parametrize(("pace", "waits"), [(1.0, [0.5, 1.5]), (2.0, [0.25, 0.75]), (0.0, [])])
def test_frames_keep_the_distances_that_they_were_recorded_with(clock, pace, waits):
    with open_bus("virtual://replaying") as bus:
        send_frames(ALL_KINDS, "virtual://replaying", pace)
        sent = [bus.recv(1.0) for _ in range(4)]
        assert bus.recv(0.0) is None
    assert clock.waits == waits
    assert [message.arbitration_id for message in sent] == [0x080, 0x181, 0x12345, 0x701]
    assert [message.is_extended_id for message in sent] == [False, False, True, False]
    assert [message.is_remote_frame for message in sent] == [False, False, False, True]
    assert bytes(sent[1].data) == b"\x01\x02"


def test_an_interface_that_fails_while_frames_are_sent_is_a_lost_bus(monkeypatch):
    def send(_message, timeout):
        raise can.CanOperationError("the cable is out")

    broken = SimpleNamespace(send=send)
    monkeypatch.setattr("omnimate.driver.bus.replay.open_bus", lambda _url: nullcontext(broken))
    with pytest.raises(BusLost, match="the cable is out"):
        send_frames([Frame(0.0, 0x181)], "virtual://x")
