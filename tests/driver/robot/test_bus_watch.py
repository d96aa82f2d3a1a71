"""Watching a bus: every frame is counted, nothing is sent, odometry runs, what is asked for is recorded."""

import threading
from collections import deque

import can
import pytest

from omnimate.driver.errors import BusError
from omnimate.driver.robot import bus_watch, recorder
from omnimate.driver.robot.bus_load import frame_bits
from omnimate.driver.robot.bus_watch import BusWatch
from omnimate.files.logs.blocks import read_log
from omnimate.files.logs.formats.python_can_logs import message_of_frame
from omnimate.files.logs.frames import ERROR, EXTENDED, FD, Frame
from omnimate.files.recordings.folder import load_recording
from omnimate.vehicle.odometry import dead_reckon


class Bus:
    """A bus that gives its messages at once, then says that it is empty and stays silent, or fails."""

    def __init__(self, messages=(), failure=None):
        self.queue = deque(messages)
        self.failure = failure
        self.empty = threading.Event()
        self.sent = []
        self.is_open = True

    def recv(self, timeout=None):
        if self.queue:
            return self.queue.popleft()
        if self.failure is not None:
            raise self.failure
        self.empty.set()
        threading.Event().wait(0.001)
        return None

    def send(self, message, timeout=None):
        self.sent.append(message)

    def shutdown(self):
        self.is_open = False


def watched(bus, vehicle=None, target=None):
    """What a watch has seen of a bus when its last message was received."""
    watch = BusWatch(lambda: bus, vehicle)
    watch.record(target)
    with watch:
        assert bus.empty.wait(30.0)
    return watch.snapshot


def messages(rows):
    return [message_of_frame(row) for row in rows]


def robot_frames(kit, counts):
    """SYNC and the answers of two wheels, 20 ms apart by the adapter's stamps."""
    for number, count in enumerate(counts):
        yield kit.frame(0x080, timestamp=100.0 + 0.02 * number)
        for node in (1, 2):
            yield kit.frame(0x180 + node, count.to_bytes(4, "little"), timestamp=100.001 + 0.02 * number)


def test_every_frame_of_every_kind_is_counted_and_nothing_is_sent():
    rows = [
        Frame(1.0, 0x181, b"ab"),
        Frame(1.1, 0x181, b"ab", EXTENDED),
        Frame(1.2, 0x181, bytes(12), FD),
        Frame(1.3, 0x004, bytes(8), ERROR),
    ]
    bus = Bus(messages(rows))
    seen = watched(bus)
    assert (seen.frames, seen.left_out, len(seen.rows)) == (4, 0, 4)
    assert bus.sent == []
    assert not bus.is_open


def test_a_frame_that_is_none_is_left_out_and_counted():
    impossible = can.Message(arbitration_id=0x181, is_extended_id=False, data=b"ab")
    impossible.arbitration_id = 0x800
    assert watched(Bus([impossible])).left_out == 1


def test_events_and_states_of_nodes_are_seen():
    seen = watched(Bus(messages([Frame(1.0, 0x705, b"\x7f"), Frame(2.0, 0x705, b"\x05")])))
    assert [event.what for event in seen.events] == ["is operational, was pre-operational"]
    assert seen.nodes["can0", 5].state == 5


def test_the_mapping_in_the_sdo_traffic_is_seen():
    write = Frame(1.0, 0x605, bytes.fromhex("23001A0120000460"))
    assert watched(Bus(messages([write]))).seen == {(5, 0x1A00, 1): 0x60040020}


def test_the_odometry_is_that_of_the_samples(kit):
    vehicle = kit.one_truck()
    seen = watched(Bus(robot_frames(kit, range(0, 1000, 100))), vehicle)
    turned = 800 * vehicle.metres_per_count("a.left")  # the last SYNC has not been closed by another
    assert seen.robot.poses["a"] == pytest.approx((turned, 0.0, 0.0))
    assert seen.robot.missing == ()
    assert seen.robot.samples == 9


def test_an_emcy_of_the_robot_is_one_event(kit):
    emcy = kit.frame(0x081, bytes.fromhex("1023050000000000"))
    seen = watched(Bus([*robot_frames(kit, (1, 2)), emcy, *robot_frames(kit, (3, 4))]), kit.one_truck())
    assert len([event for event in seen.events if "EMCY" in event.what]) == 1


def test_a_recording_from_there_is_the_drive_of_the_robot(kit, tmp_path):
    vehicle = kit.one_truck()
    seen = watched(Bus(robot_frames(kit, range(0, 1000, 100))), vehicle, tmp_path / "drive")
    recording = load_recording(tmp_path / "drive")
    assert recording.channel_counts("a.left").tolist() == list(range(0, 1000, 100))
    assert dead_reckon(recording)[-2] == pytest.approx(seen.robot.poses["a"])
    assert seen.recording is None


def test_without_a_vehicle_a_log_is_recorded_with_can_fd(tmp_path):
    rows = [Frame(1.0, 0x181, b"ab"), Frame(1.2, 0x181, bytes(12), FD)]
    watched(Bus(messages(rows)), target=tmp_path / "can.log")
    assert b"181##0" in (tmp_path / "can.log").read_bytes()
    assert len(read_log(tmp_path / "can.log").frames) == 1


def test_a_recording_that_cannot_be_written_is_told_and_the_watch_goes_on(kit, tmp_path):
    (tmp_path / "can.log").write_text("taken")
    seen = watched(Bus(robot_frames(kit, (1, 2))), kit.one_truck(), tmp_path)
    assert seen.frames == 6
    assert any("it holds a recording" in event.what for event in seen.events)


@pytest.mark.parametrize("with_vehicle", [False, True])
def test_a_disk_without_space_is_reported_and_the_bus_is_not_lost(kit, tmp_path, monkeypatch, with_vehicle):
    writer = bus_watch.CandumpWriter
    for module in (bus_watch, recorder):
        monkeypatch.setattr(module, "CandumpWriter", lambda _path: writer("/dev/full", sync_interval=3600.0))
    vehicle = kit.one_truck() if with_vehicle else None
    seen = watched(Bus(robot_frames(kit, range(400))), vehicle, tmp_path / "drive")
    missing, _ = (event.what for event in seen.events if "No space left" in event.what)
    assert "frames are missing" in missing
    assert seen.frames == 1200
    assert not any("bus lost" in event.what for event in seen.events)


@pytest.mark.parametrize("with_vehicle", [False, True])
def test_a_bus_that_was_lost_is_opened_again_and_both_are_told(kit, monkeypatch, with_vehicle):
    monkeypatch.setattr(bus_watch, "AGAIN", 0.001)
    vehicle = kit.one_truck() if with_vehicle else None
    first = Bus(robot_frames(kit, (0, 100)), can.CanOperationError("unplugged"))
    second = Bus(robot_frames(kit, (5000, 5100, 5200)))
    answers = iter([first, BusError("bus", "not there"), second])

    def opened():
        answer = next(answers)
        if isinstance(answer, Exception):
            raise answer
        return answer

    with BusWatch(opened, vehicle) as watch:
        assert second.empty.wait(30.0)
    seen = watch.snapshot
    assert seen.frames == 15
    words = [event.what for event in seen.events]
    assert any("bus lost" in word and "unplugged" in word for word in words)
    assert any("bus is back" in word for word in words)
    assert seen.lost is None
    if vehicle is not None:  # what was driven while the bus was away is not known
        assert seen.robot.poses["a"][0] == pytest.approx(100 * vehicle.metres_per_count("a.left"))


def test_the_load_counts_the_bits_of_classical_frames():
    assert frame_bits(8, stuffed=False) == 111
    assert frame_bits(8, stuffed=False, extended=True) == 131
    assert frame_bits(8, stuffed=True, extended=True) == 131 + (33 + 20 + 64) // 4
