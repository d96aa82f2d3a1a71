"""Events of a bus: what a frame says that a person wants to know, and nothing of all the others."""

import pytest
from hypothesis import given

from omnimate.files.logs.bus_events import BusEvent, BusEvents
from omnimate.files.logs.frames import ERROR, EXTENDED, FD, Frame
from tests.files.logs.any_frames import any_frames


def events_of(*rows):
    """The events in frames, one second apart."""
    events = BusEvents()
    taken = (events.take(Frame(float(number), *row)) for number, row in enumerate(rows))
    return [event for event in taken if event is not None]


def test_an_emcy_is_told_with_its_words_and_its_end_is_no_problem():
    fault, reset = events_of((0x085, bytes.fromhex("1023050000000000")), (0x085, bytes(8)))
    assert fault == BusEvent(0.0, 5, fault.what, is_problem=True, is_health=True)
    assert "EMCY 2310h" in fault.what
    assert "error register 05h" in fault.what
    assert not reset.is_problem


def test_a_heartbeat_is_an_event_where_the_state_changes():
    (event,) = events_of((0x705, b"\x05"), (0x705, b"\x05"), (0x705, b"\x7f"))
    assert event == BusEvent(2.0, 5, "is pre-operational, was operational", is_health=True)


def test_the_toggle_bit_of_node_guarding_is_no_change():
    assert events_of((0x705, b"\x05"), (0x705, b"\x85")) == []


def test_a_second_boot_up_is_a_problem_the_first_is_not():
    first, second = events_of((0x705, b"\x00"), (0x705, b"\x00"))
    assert (first.what, first.is_problem) == ("boot-up", False)
    assert second.is_problem


def test_nmt_commands_and_sdo_aborts_are_told():
    start, abort = events_of((0x000, b"\x01\x05"), (0x585, bytes.fromhex("8000180100000206")))
    assert (start.node, start.is_problem) == (5, False)
    assert "abort of 1800h" in abort.what
    assert abort.is_problem


def test_an_error_frame_is_a_problem_of_the_bus():
    assert events_of((0x004, bytes(8), ERROR)) == [
        BusEvent(0.0, None, "error frame of the adapter", is_problem=True)
    ]


@pytest.mark.parametrize(
    "row", [(0x181, bytes(8)), (0x080, b""), (0x705, b"\0", EXTENDED), (0x705, b"\0", FD)]
)
def test_process_data_sync_and_frames_that_are_none_of_canopen_are_no_events(row):
    assert events_of(row) == []


@given(any_frames())
def test_no_frame_breaks_it(frame):
    BusEvents().take(frame)
