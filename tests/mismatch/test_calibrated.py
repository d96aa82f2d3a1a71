"""What any recording with poses calibrates: how the reference is mounted, wheelbase and diameters."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.mismatch import diagnose
from omnimate.mismatch.candidates.nuisances import WANDERING, add_nuisances
from omnimate.mismatch.candidates.regression import Regression
from omnimate.mismatch.candidates.terms import calibrated_terms
from omnimate.mismatch.diagnosis import ASSERTED
from omnimate.mismatch.noise.levels import DEFAULT_LEVELS
from omnimate.mismatch.recording.signals import signals_of
from omnimate.mismatch.recording.windows import windows_of

OFFSET = {"x": 0.02, "y": -0.012, "yaw": 0.015}


def beside_the_axle(recording, offset):
    """Return a recording whose truck a is measured by a reference that sits elsewhere."""
    poses = recording.poses
    own = (poses.body == "a")[:, None]
    return replace(
        recording, poses=replace(poses, pose=np.where(own, offset.measured(poses.pose), poses.pose))
    )


@pytest.fixture(scope="module")
def mounted(drive, watched, effect):
    """Return the diagnosis of a healthy robot whose reference sits beside truck a's axle."""
    return diagnose([beside_the_axle(watched(drive()), effect("reference_offset", "a", **OFFSET))])


def test_a_reference_beside_the_axle_is_no_fault_of_the_robot(mounted):
    assert not [finding for finding in mounted.findings if finding.probability >= ASSERTED]


def test_its_place_is_calibrated_within_its_uncertainty(mounted):
    parameters = {
        (single.effect, single.component): {one.name: one for one in single.parameters}
        for single in mounted.calibrated
    }
    for name, value in OFFSET.items():
        told = parameters["reference_offset", "a"][name]
        assert abs(told.value - value) < 4.0 * told.sigma
        assert abs(parameters["reference_offset", "b"][name].value) < 4.0 * told.sigma
    assert (
        abs(parameters["wheelbase", "a"]["ratio"].value - 1.0)
        < 4.0 * parameters["wheelbase", "a"]["ratio"].sigma
    )


def test_what_is_calibrated_is_in_the_json_and_in_the_effects_only_where_it_helps(mounted):
    names = [(effect.name, effect.component) for effect in mounted.effects]
    listed = [(single["effect"], single["component"]) for single in mounted.as_json()["calibrated"]]
    assert ("wheelbase", "a") in listed
    assert names == [name for name in listed if name[0] == "reference_offset"]  # the robot is healthy


def test_poses_now_and_then_calibrate_only_how_they_are_measured(drive, watched):
    often, seldom = (signals_of(watched(drive(), every=every)) for every in (20, 400))
    assert {single.effect for single in calibrated_terms([often])} == {
        "reference_offset",
        "wheelbase",
        "wheel_diameter",
    }
    assert {single.effect for single in calibrated_terms([seldom])} == {"reference_offset"}


def test_a_reference_beside_the_axle_that_is_seen_once_in_seconds_is_no_fault_either(drive, watched, effect):
    recording = beside_the_axle(watched(drive(), every=400), effect("reference_offset", "a", **OFFSET))
    answer = diagnose([recording])
    assert not [finding for finding in answer.findings if finding.probability >= ASSERTED]
    (place,) = [each for each in answer.calibrated if each.component == "a"]
    for parameter in place.parameters:
        assert abs(parameter.value - OFFSET[parameter.name]) < 4.0 * parameter.sigma


def test_late_stamps_of_one_recording_are_no_business_of_another(drive, watched):
    first, second = (windows_of(signals_of(watched(drive(laps=1, seed=seed)))) for seed in (4, 5))
    regression = Regression([first, second], DEFAULT_LEVELS, ())
    columns = add_nuisances(regression)
    power = np.stack(
        [(regression.white[regression.owner == owner][:, columns] ** 2).sum(axis=0) for owner in (0, 1)]
    )
    late = 2 * (1 + len(WANDERING))
    assert np.array_equal(power[:, -late:] > 0.0, np.repeat(np.eye(2, dtype=bool), late // 2, axis=1))
    assert np.all(power[:, :-late] > 0.0)


def test_recordings_with_and_without_poses_share_nuisances_in_any_order(drive, watched):
    recordings = watched(drive(laps=1)), drive(laps=1, seed=5)
    models = [windows_of(signals_of(recording)) for recording in recordings]

    def columns(order):
        regression = Regression([models[number] for number in order], DEFAULT_LEVELS, ())
        white = regression.white[:, add_nuisances(regression)]
        return [white[regression.rows_of(order.index(number))] for number in (0, 1)]

    for one, other in zip(columns([0, 1]), columns([1, 0]), strict=True):
        assert one == pytest.approx(other, abs=1e-9)
