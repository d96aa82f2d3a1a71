"""An error without a name may depend on what the drive changes, and on nothing that is its noise."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.mismatch.candidates.quantities import shared_quantities
from omnimate.mismatch.candidates.regression import slices_of
from omnimate.mismatch.candidates.terms import smooth_terms
from omnimate.mismatch.candidates.unknown import unknown_errors
from omnimate.mismatch.recording.signals import signals_of
from omnimate.motion.paths import out_and_back
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth

TURNING = {"turn rate", "angle of joint_a", "turns of joint_b", "yaw acceleration of link"}


@pytest.fixture(scope="module")
def straight():
    """Return a drive to and fro, on which only the floor's roughness turns the robot."""
    vehicle = reference_vehicle()
    return simulate(vehicle, Truth(vehicle, seed=2), out_and_back(3.0, runs=1), start_time=0.0)


def test_on_a_straight_drive_nothing_depends_on_the_noise_of_measured_poses(straight, watched, drive):
    """The path follows the poses: where it does not turn, its heading is their noise."""
    along, turning = (signals_of(watched(each)) for each in (straight, drive(laps=1)))
    [straight_curves], [curves] = shared_quantities([along]), shared_quantities([turning])
    assert [number for number, curve in enumerate(straight_curves["place of a"]) if curve.std()] == [0, 3]
    for name in ("heading of a", "place of a", "place and heading of a"):
        assert all(curve.std() > 0.0 for curve in curves[name])
    assert not any("heading" in name for name in straight_curves)


@pytest.mark.parametrize("turning", [False, True])
def test_on_a_straight_drive_nothing_depends_on_turns_joints_or_heading_and_no_error_is_made_per_turn(
    regression, straight, drive, turning
):
    """How far wheels turn a robot there is what its counts round off, and so is its heading."""
    terms = unknown_errors(regression(drive(laps=1) if turning else straight)).terms
    quantities = {term.fixed["quantity"] for term in terms}
    assert "speed of a.left" in quantities
    assert quantities & TURNING == (TURNING if turning else set())
    assert any("heading" in quantity for quantity in quantities) is turning
    assert any(term.fixed["acts_on"] == "turn" for term in terms) is turning


def test_what_varies_in_one_recording_only_is_offered_for_none(drive):
    steady = signals_of(drive(laps=1))
    jitter = 1e-4 * np.sin(np.arange(len(steady.block)))
    block = replace(steady.block, period=steady.block.period.mean() + jitter)
    exact = replace(steady.block, period=np.full(len(steady.block), steady.block.period.mean()))
    recordings = [replace(steady, block=each) for each in (block, exact)]
    names = [list(curves) for curves in shared_quantities(recordings)]
    assert names[0] == names[1]
    assert "SYNC period" not in names[0]
    assert "SYNC period" in shared_quantities(recordings[:1])[0]


def test_on_a_straight_drive_no_scrub_is_looked_for(straight, drive):
    names = [{term.effect for term in smooth_terms([signals_of(each)])} for each in (straight, drive(laps=1))]
    assert "turn_scrub" not in names[0]
    assert "turn_scrub" in names[1]


def test_what_a_robot_does_after_a_pose_predicts_no_noise_of_that_pose(regression, watched, drive):
    """A robot that steers by its poses answers their noise within the next samples."""
    seen, quantity = regression(watched(drive(laps=1))), "speed of a.left"
    unknown = unknown_errors(seen)
    place = dict(zip(unknown.quantities, slices_of(unknown.quantities.values()), strict=True))[quantity]
    [windows] = seen.windows
    [shared] = shared_quantities([windows.signals])
    at_ends = windows.at_ends(np.stack(shared[quantity], axis=1))
    of_poses = seen.channel >= windows.linkage
    for rows, late in ((~of_poses, 0), (of_poses, 1)):
        later = rows & (seen.moment > 1)
        moment = seen.moment[later] - late
        expected = np.hstack([at_ends[moment], at_ends[moment] - at_ends[moment - 1]])
        np.testing.assert_array_equal(unknown.curves[later, place], expected)
