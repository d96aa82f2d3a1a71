"""From frames to samples: which PDO counts, what is left out, and what is said about it."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.files.logs.assemble import assemble
from omnimate.files.logs.frame_classes import count_classes
from omnimate.files.logs.frames import ERROR, EXTENDED, REMOTE, Frame, frames_of
from omnimate.vehicle.errors import RecordingError
from omnimate.vehicle.parameters import Bus, Drive, Encoder, Truck, VehicleParameters
from omnimate.vehicle.recording import Gap

PERIOD = 0.01


def wheel(channel, node, **changes):
    """A wheel encoder of 16 bits with 1000 counts per turn."""
    fields = {
        "cob_id": 0x180 + node,
        "start_bit": 0,
        "bits": 16,
        "signed": True,
        "sign": 1,
        "counts_per_turn": 1000.0,
    }
    return Encoder(channel=channel, node=node, **(fields | changes))


def robot(*encoders, drives=()):
    """A robot with one truck."""
    encoders = encoders or (wheel("a.left", 1), wheel("a.right", 2))
    return VehicleParameters("r", {"a": Truck(0.3, 0.15, 0.15)}, None, Bus(500000, PERIOD), encoders, drives)


def sync(index):
    return Frame(index * PERIOD, 0x080)


def pdo(index, node, counts, *, delay=0.001, size=2):
    return Frame(
        index * PERIOD + delay, 0x180 + node, (counts % 65536).to_bytes(2, "little")[:size].ljust(size, b"\0")
    )


def drive(samples, left=lambda index: 10 * index, right=lambda index: -5 * index):
    """The frames of an undisturbed drive, sample by sample."""
    return [
        [sync(index), pdo(index, 1, left(index)), pdo(index, 2, right(index))] for index in range(samples)
    ]


def assembled(rows, vehicle=None):
    """The assembly of lists of frames."""
    return assemble(frames_of([frame for row in rows for frame in row]), vehicle or robot())


def test_every_sync_opens_a_sample_with_its_time_and_its_counts():
    recording = assembled(drive(5)).recording
    assert recording.time.tolist() == [index * PERIOD for index in range(5)]
    assert recording.counts.tolist() == [[10 * index, -5 * index] for index in range(5)]
    assert recording.present.all()
    assert recording.gaps == ()


def test_frames_before_the_first_sync_are_ignored():
    recording = assembled([[pdo(-1, 1, 999), Frame(-0.5, 0x701, b"\x05")], *drive(3)]).recording
    assert recording.time[0] == 0.0
    assert recording.counts[0].tolist() == [0, 0]


def test_a_missing_answer_leaves_the_last_count_and_a_gap():
    rows = drive(6)
    del rows[2][1], rows[3][1]
    assembly = assembled(rows)
    assert assembly.recording.counts[:, 0].tolist() == [0, 10, 10, 10, 40, 50]
    assert assembly.recording.present[:, 0].tolist() == [True, True, False, False, True, True]
    assert assembly.recording.gaps == (Gap("a.left", 1 * PERIOD, 4 * PERIOD, "missing"),)
    assert (assembly.pdos[0].used, assembly.pdos[0].missing) == (4, 2)


@pytest.mark.parametrize("size", [0, 1, 3, 8])
def test_an_answer_of_the_wrong_length_enters_no_sample(size):
    rows = drive(5)
    rows[2][1] = pdo(2, 1, 20, size=size)
    assembly = assembled(rows)
    assert assembly.recording.present[:, 0].tolist() == [True, True, False, True, True]
    assert assembly.pdos[0].wrong_length == 1


def test_a_pdo_may_carry_more_than_the_vehicle_uses():
    rows = [[sync(index), pdo(index, 1, index, size=8), pdo(index, 2, index)] for index in range(4)]
    assert assembled(rows).recording.present.all()


def test_a_restarted_wheel_goes_on_where_the_other_wheel_says_it_must_be():
    rows = drive(4, left=lambda index: 5000 + 10 * index)
    rows[2][1] = Frame(2 * PERIOD + 0.001, 0x701, b"\x00")
    after = [
        [sync(index), pdo(index, 1, 10 * (index - 4)), pdo(index, 2, -5 * index)] for index in range(4, 8)
    ]
    rows[3].pop(1)
    assembly = assembled(rows + after)
    assert assembly.recording.counts[:, 0].tolist() == [5000, 5010, 5010, 5010, 5040, 5050, 5060, 5070]
    assert assembly.recording.gaps == (Gap("a.left", 1 * PERIOD, 4 * PERIOD, "reboot"),)
    assert assembly.pdos[0].restarts == 1
    assert assembly.recording.present[:, 1].all()


def test_a_heartbeat_that_is_no_boot_up_changes_nothing():
    rows = drive(4)
    rows[2].append(Frame(2 * PERIOD + 0.002, 0x701, b"\x05"))
    assembly = assembled(rows)
    assert assembly.recording.gaps == ()
    assert assembly.pdos[0].restarts == 0


def test_frames_are_counted_as_what_they_are():
    rows = drive(3)
    rows[1] += [
        Frame(0.015, 0x705, b"\x05"),
        Frame(0.015, 0x081, bytes(8)),
        Frame(0.015, 0x601, bytes(8)),
        Frame(0.015, 0x000, b"\x01\x00"),
        Frame(0.015, 0x285, b"\x00"),
        Frame(0.015, 0x285, b"\x00"),
        Frame(0.015, 0x010, b"\x00"),
        Frame(0.015, 0x181, b"\x00\x00", EXTENDED),
        Frame(0.015, 0x181, b"", REMOTE),
        Frame(0.015, 0x181, bytes(8), ERROR),
        Frame(0.015, 0x080, bytes(8)),
    ]
    assembly = assembled(rows)
    counts = count_classes(frames_of([frame for row in rows for frame in row]), robot())
    assert {name: count for name, count in counts.items() if count} == {
        "SYNC": 3, "PDO": 6, "unknown PDO": 2, "heartbeat": 1, "EMCY": 1, "SDO": 1, "NMT": 1,
        "remote": 1, "error": 1, "foreign": 3,
    }  # fmt: skip
    assert assembly.unknown_pdos == {0x285: 2}
    assert assembly.recording.present.all()


def test_the_bus_with_the_vehicle_on_it_is_chosen_among_several():
    other = [Frame(0.0, 0x080, channel="can1"), Frame(0.0, 0x181, b"\x63\x00", channel="can1")]
    recording = assembled([other, *drive(4)]).recording
    assert len(recording) == 4
    assert recording.counts[:, 0].tolist() == [0, 10, 20, 30]


def test_a_log_without_sync_is_cut_at_the_first_pdo():
    recording = assembled([row[1:] for row in drive(4)]).recording
    assert recording.counts.tolist() == [[10 * index, -5 * index] for index in range(4)]


def test_a_log_of_another_robot_is_an_error_that_says_what_was_expected():
    with pytest.raises(
        RecordingError, match=r"neither SYNC \(080h\) nor a PDO of this vehicle \(181h, 182h\).*285h"
    ):
        assembled([[Frame(0.0, 0x285, b"\x00")]])


def test_commands_hold_from_the_sample_after_they_were_sent():
    drives = (Drive("a.right", 12, 0x20C, -1, 1000.0),)
    rows = drive(4)
    rows[1].append(Frame(0.015, 0x20C, (500).to_bytes(4, "little", signed=True)))
    commands = assembled(rows, robot(drives=drives)).recording.commands
    assert np.isnan(commands[:, 0]).all()
    assert np.isnan(commands[:2, 1]).all()
    assert commands[2:, 1].tolist() == pytest.approx([-math.pi] * 2)


def test_a_log_without_commands_has_none():
    assert (
        assembled(drive(3), robot(drives=(Drive("a.left", 11, 0x20B, 1, 1000.0),))).recording.commands is None
    )


@st.composite
def shared_pdos(draw):
    """Two wheels anywhere in one PDO, of any width and sign."""
    widths = [draw(st.integers(8, 32)), draw(st.integers(8, 32))]
    first = draw(st.integers(0, 64 - sum(widths)))
    second = draw(st.integers(first + widths[0], 64 - widths[1]))
    return tuple(
        wheel(channel, 1, start_bit=start, bits=width, signed=draw(st.booleans()))
        for channel, start, width in zip(("a.left", "a.right"), (first, second), widths, strict=True)
    )


@given(
    encoders=shared_pdos(), steps=st.lists(st.tuples(*[st.integers(-50, 50)] * 2), min_size=1, max_size=30)
)
def test_any_field_of_any_width_and_sign_is_unwrapped_in_both_directions(encoders, steps):
    counts = np.cumsum(np.array([(0, 0), *steps]), axis=0)
    size = max((encoder.start_bit + encoder.bits + 7) // 8 for encoder in encoders)
    rows = []
    for index, row in enumerate(counts.tolist()):
        word = sum((value % 2**e.bits) << e.start_bit for value, e in zip(row, encoders, strict=True))
        rows.append([sync(index), Frame(index * PERIOD, 0x181, word.to_bytes(size, "little"))])
    recording = assembled(rows, robot(*encoders)).recording
    assert np.array_equal(recording.counts - recording.counts[0], counts)


@settings(max_examples=30)
@given(
    order=st.permutations(list(range(12))),
    noise=st.lists(
        st.builds(
            Frame,
            st.just(0.0),
            st.integers(0, 0x7FF),
            st.binary(max_size=8),
            st.just(0),
            st.none(),
            st.just("can0"),
        ),
        max_size=20,
    ),
)
def test_no_mixture_of_frames_breaks_the_assembly(order, noise):
    frames = [frame for row in drive(4) for frame in row]
    mixed = [frames[index] for index in order] + noise
    recording = assembled([mixed]).recording
    assert len(recording) == sum(frame.can_id == 0x080 and len(frame.data) <= 1 for frame in mixed)
