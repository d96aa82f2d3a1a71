"""Series on clocks of their own become one recording."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.files.errors import SourceError
from omnimate.files.importers.clock import recording_of
from omnimate.files.importers.robots import single_truck
from omnimate.files.importers.series import Series, poses_of
from omnimate.files.logs.assemble import assemble
from omnimate.files.logs.recording_to_frames import frames_of_recording
from omnimate.vehicle.parameters import Drive, Truck
from omnimate.vehicle.recording import Recording

ROBOT = single_truck("tried", Truck(0.5, 0.2, 0.2), 1000.0, 0.02)
TIME = 0.02 * np.arange(10)


def made(left, right, **more):
    return recording_of(ROBOT, {"a.left": left, "a.right": right}, "test", **more)


@given(
    st.lists(st.tuples(*[st.none() | st.integers(-200, 200) | st.integers(-(10**6), 10**6)] * 2), min_size=2),
    st.lists(st.sampled_from([0.02, 0.04]), min_size=100, max_size=100),
    st.lists(st.none() | st.floats(-3.0, 3.0), min_size=100, max_size=100),
    st.integers(13, 32),
    st.booleans(),
)
def test_an_import_is_what_its_frames_on_a_bus_would_have_given(steps, periods, speeds, bits, signed):
    """With missing values, jumps, wraps, two encoders in one PDO, and commands."""
    left, right = (replace(encoder, bits=bits, signed=signed) for encoder in ROBOT.encoders)
    right = replace(right, cob_id=left.cob_id, start_bit=32)
    robot = replace(ROBOT, encoders=(left, right), drives=(Drive("a.left", 11, 0x20B, -1, 40000.0),))
    moved = np.array([[np.nan if step is None else step for step in row] for row in steps[:100]], float)
    moved[[0, 1]] = np.nan_to_num(moved[[0, 1]])
    counts = np.where(np.isnan(moved), np.nan, np.cumsum(np.nan_to_num(moved), axis=0))
    time = 100.0 + np.cumsum(periods[: len(counts)])
    commands = np.column_stack((np.array(speeds[: len(counts)], float), np.full(len(counts), np.nan)))
    series = {
        name: Series(time, column, "counts", "test")
        for name, column in zip(robot.channels, counts.T, strict=True)
    }
    seen = recording_of(robot, series, "test", commands=commands)
    present = np.isfinite(counts)
    on_bus = Recording(seen.vehicle, time, np.nan_to_num(counts).astype(np.int64), present, commands=commands)
    expected = assemble(frames_of_recording(on_bus), seen.vehicle).recording
    for name in ("time", "counts", "present"):
        np.testing.assert_array_equal(getattr(seen, name), getattr(expected, name))
    assert seen.gaps == expected.gaps
    assert (seen.commands is None) == (expected.commands is None)
    if seen.commands is not None:
        np.testing.assert_array_equal(seen.commands, expected.commands)


@given(st.floats(0.001, 0.019))
def test_channels_on_two_clocks_meet_on_the_slower_one_to_half_a_count(shift):
    slow, fast = np.arange(0.0, 2.0, 0.02), np.arange(0.0, 2.0, 0.005) + shift
    recording = made(
        Series(slow, np.rint(500.0 * slow), "counts", "left"),
        Series(fast, np.rint(700.0 * fast), "counts", "right"),
    )
    assert np.abs(recording.channel_counts("a.left") - 500.0 * recording.time).max() <= 0.5 + 1e-9
    assert np.abs(recording.channel_counts("a.right") - 700.0 * recording.time).max() <= 1.0 + 1e-9


def test_a_counter_that_wraps_is_followed_over_its_wrap():
    time = 0.02 * np.arange(10)
    raw = (2.0**31 - 25.0 + 10.0 * np.arange(10) + 2.0**31) % 2.0**32 - 2.0**31
    other = Series(time + 0.001, np.arange(10.0), "counts", "right")
    assert raw.min() < 0.0 < raw.max()
    shared = made(Series(time, raw, "counts", "left"), Series(time, np.arange(10.0), "counts", "right"))
    apart = made(Series(time, raw, "counts", "left"), other)
    for recording in (shared, apart):
        assert set(np.diff(recording.channel_counts("a.left"))) == {10}


def test_a_pause_is_filled_with_syncs_that_nobody_answers_and_no_count_is_lost():
    time = np.concatenate((np.arange(50), np.arange(150, 200))) * 0.02
    counts = np.concatenate((np.arange(50), np.arange(150, 200))) * 30.0
    recording = made(Series(time, counts, "counts", "left"), Series(time, counts, "counts", "right"))
    assert len(recording) == 200
    assert recording.is_present("a.left").sum() == 100
    assert recording.channel_counts("a.left")[-1] == counts[-1]
    assert [gap.reason for gap in recording.gaps] == ["missing", "missing"]


@pytest.mark.parametrize(
    ("left", "right", "poses", "problem"),
    [
        (TIME, TIME, TIME + 1.7e9, r"the poses lie at 1700000000\.000.*one clock"),
        (TIME, TIME + 9.0, None, "no time in common"),
        (np.append(TIME, 9e3), np.append(TIME, 9e3), None, "cut it in two"),
        (1e3 * TIME, 1e3 * TIME, None, "check the unit of time"),
    ],
)
def test_clocks_that_cannot_be_one_drive_are_refused(left, right, poses, problem):
    wheels = (Series(time, np.arange(float(len(time))), "counts", "wheel") for time in (left, right))
    placed = None if poses is None else poses_of("a", poses, np.zeros((10, 3)))
    with pytest.raises(SourceError, match=problem):
        made(*wheels, poses=placed)


def test_a_channel_that_nothing_gives_is_named():
    wheel = Series(np.arange(3.0), np.arange(3.0), "counts", "wheel")
    with pytest.raises(SourceError, match=r"nothing gives channel a\.right"):
        recording_of(ROBOT, {"a.left": wheel}, "test")
