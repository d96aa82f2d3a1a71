"""What every robot has a little of."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.effects.ageing import SYNC_SKEW
from omnimate.files.recordings.folder import load_recording
from omnimate.mismatch import diagnose
from omnimate.mismatch.candidates.nuisances import BEFORE, _unforeseen, is_merged, nuisances
from omnimate.mismatch.evidence.rows import whiten_nuisances
from omnimate.mismatch.recording.signals import signals_of
from omnimate.motion.paths import out_and_back
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from studies.mismatch.engines.scene import Case, make


@given(st.integers(0, 10_000), st.integers(20, 80))
def test_what_is_not_foreseen_goes_with_nothing_that_was_there_before(seed, count):
    values = np.cumsum(np.random.default_rng(seed).normal(size=count))
    left = _unforeseen(values)
    for late in range(1, BEFORE + 1):
        assert abs(left[late:] @ values[:-late]) < 1e-6 * (np.abs(values) @ np.abs(values))


@pytest.mark.slow
def test_what_wheels_round_off_is_no_delay_of_the_link(tmp_path):
    """Truck b holds the link's length, so that little but rounding is in the rate of the link."""
    make(tmp_path, Case(kind="null", effects=(), drive="shuttle", poses="none", trucks=2), 3)
    assert diagnose([load_recording(tmp_path / "1")]).findings == ()


WHEELS = ("a.left", "a.right", "b.left", "b.right")


@pytest.fixture(scope="module")
def shuttled(effect, regression):
    """Return a function that gives the chi-square of a shuttle with plays, alone and beside nuisances."""

    def chi_squares(*wheels):
        vehicle = reference_vehicle()
        effects = tuple(effect("gear_backlash", wheel, width=8e-4) for wheel in wheels)
        drive = simulate(vehicle, Truth(vehicle, seed=3, effects=effects), out_and_back(2.0, 3))
        data = regression(drive)
        rows = data.white[:, :1], whiten_nuisances(data.white[:, :1], data.whitened(nuisances(data.windows)))
        return np.array([float((each**2).sum()) for each in rows])

    return chi_squares


def test_a_play_that_all_gears_have_is_how_they_are_made_and_that_of_a_single_gear_is_not(shuttled):
    healthy = shuttled()
    whole, left = shuttled(*WHEELS) - healthy
    assert left < 0.1 * whole
    whole, left = shuttled("a.right") - healthy
    assert left > 0.5 * whole


@pytest.mark.parametrize(("late", "merged"), [(0.0, True), (0.2 * SYNC_SKEW, True), (3.0 * SYNC_SKEW, False)])
def test_poses_with_the_stamps_of_samples_were_laid_along_them(drive, watched, late, merged):
    recording = watched(drive(laps=1))
    poses = replace(recording.poses, time=recording.poses.time + late)
    assert is_merged(signals_of(replace(recording, poses=poses))) == merged
    assert not is_merged(signals_of(replace(recording, poses=None)))
