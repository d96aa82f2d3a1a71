"""What the frames on a bus say by themselves."""

import can
import pytest

from omnimate.driver.scan.traffic import BusTraffic


def heard(*frames):
    made = BusTraffic()
    for number, (can_id, data, *flags) in enumerate(frames):
        kind = {"is_extended_id": False, **dict.fromkeys(flags, True)}
        message = can.Message(arbitration_id=can_id, data=data, **kind)
        made.take(message, 0.1 * number)
    return made


@pytest.mark.parametrize(
    ("can_id", "data", "what"),
    [
        (0x080, b"", "SYNC"),
        (0x000, b"\x01\x05", "NMT commands"),
        (0x605, bytes(8), "SDO requests"),
        (0x205, bytes(4), "PDOs to drives or outputs"),
    ],
)
def test_what_a_master_alone_sends_shows_a_master(can_id, data, what):
    assert list(heard((can_id, data)).masters) == [what]


def test_a_guarded_node_is_no_producer_of_heartbeats():
    made = heard((0x705, b"", "is_remote_frame"), (0x705, b"\x85"))
    assert made.guarded == {5}
    assert made.states == {5: 5}
    assert made.masters["node guarding"] == 1


@pytest.mark.parametrize("can_id", [0x185, 0x705, 0x585, 0x085])
def test_what_nodes_send_shows_no_master(can_id):
    assert not heard((can_id, b"\x05")).masters


def test_the_period_is_the_median_so_that_a_lost_frame_does_not_change_it():
    made = BusTraffic()
    for at in (0.0, 0.1, 0.2, 0.4, 0.5):
        made.take(can.Message(arbitration_id=0x080, is_extended_id=False), at)
        made.take(can.Message(arbitration_id=0x705, data=b"\x05", is_extended_id=False), at)
    assert made.sync_period == pytest.approx(0.1)
    assert made.heartbeat_period(5) == pytest.approx(0.1)
    assert made.heartbeat_period(6) is None


@pytest.mark.parametrize("flag", ["is_extended_id", "is_error_frame", "is_fd"])
def test_frames_of_another_kind_say_nothing(flag):
    assert heard((0x705, b"\x05", flag)) == BusTraffic()
