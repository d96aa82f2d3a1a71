"""Series on clocks of their own become one recording."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.files.importers.clock import recording_of
from omnimate.files.importers.errors import SourceError
from omnimate.files.importers.poses import poses_of
from omnimate.files.importers.robots import single_truck
from omnimate.files.importers.series import Series
from omnimate.files.recordings.folder import load_recording, save_recording
from omnimate.vehicle.parameters import Truck

ROBOT = single_truck("tried", Truck(0.5, 0.2, 0.2), 1000.0, 0.02)


def made(left, right, **more):
    return recording_of(ROBOT, {"a.left": left, "a.right": right}, "test", **more)


@given(st.lists(st.tuples(st.integers(-100, 100), st.integers(-100, 100)), min_size=2, max_size=50))
def test_counts_on_one_clock_are_not_touched(steps):
    counts = np.cumsum(np.array(steps), axis=0)
    time = 100.0 + 0.02 * np.arange(len(steps))
    left, right = (Series(time, column.astype(float), "counts", "test") for column in counts.T)
    recording = made(left, right)
    np.testing.assert_array_equal(recording.counts, counts)
    np.testing.assert_array_equal(recording.time, time)
    assert recording.present.all()
    assert recording.vehicle.bus.sync_period == 0.02


def test_what_is_returned_is_what_its_folder_holds(drive, tmp_path):
    save_recording(drive, tmp_path)
    loaded = load_recording(tmp_path)
    np.testing.assert_array_equal(loaded.counts, drive.counts)
    np.testing.assert_allclose(loaded.time, drive.time, atol=1e-6)
    np.testing.assert_array_equal(loaded.poses.pose, drive.poses.pose)


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


def test_a_missing_value_is_a_sample_without_that_channel():
    time, left = 0.02 * np.arange(10), 10.0 * np.arange(10)
    left[4] = np.nan
    recording = made(Series(time, left, "counts", "left"), Series(time, np.arange(10.0), "counts", "right"))
    np.testing.assert_array_equal(np.flatnonzero(~recording.is_present("a.left")), [4])
    assert recording.channel_counts("a.left")[-1] == 90


def test_a_pause_is_filled_with_syncs_that_nobody_answers_and_no_count_is_lost():
    time = np.concatenate((np.arange(50), np.arange(150, 200))) * 0.02
    counts = np.concatenate((np.arange(50), np.arange(150, 200))) * 30.0
    recording = made(Series(time, counts, "counts", "left"), Series(time, counts, "counts", "right"))
    assert len(recording) == 200
    assert recording.is_present("a.left").sum() == 100
    assert recording.channel_counts("a.left")[-1] == counts[-1]
    assert [gap.reason for gap in recording.gaps] == ["missing", "missing"]


def test_poses_on_another_clock_are_refused():
    time = 0.02 * np.arange(10)
    wheel = Series(time, np.arange(10.0), "counts", "wheel")
    with pytest.raises(SourceError, match=r"the poses lie at 1700000000\.000.*one clock"):
        made(wheel, wheel, poses=poses_of("a", time + 1.7e9, np.zeros((10, 3))))


def test_channels_on_clocks_that_never_meet_are_refused():
    time = 0.02 * np.arange(10)
    with pytest.raises(SourceError, match="no time in common"):
        made(Series(time, time, "rad", "left"), Series(time + 9.0, time, "rad", "right"))


def test_a_drive_of_hours_with_nothing_in_it_is_refused():
    time = np.array([0.0, 0.02, 0.04, 9000.0])
    wheel = Series(time, np.arange(4.0), "counts", "wheel")
    with pytest.raises(SourceError, match="cut it in two"):
        made(wheel, wheel)


def test_milliseconds_taken_for_seconds_are_found_by_the_period():
    time = 20.0 * np.arange(10)
    wheel = Series(time, np.arange(10.0), "counts", "wheel")
    with pytest.raises(SourceError, match="check the unit of time"):
        made(wheel, wheel)


def test_a_channel_that_nothing_gives_is_named():
    wheel = Series(np.arange(3.0), np.arange(3.0), "counts", "wheel")
    with pytest.raises(SourceError, match=r"nothing gives channel a\.right"):
        recording_of(ROBOT, {"a.left": wheel}, "test")
