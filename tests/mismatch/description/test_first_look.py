"""Before any search: a robot that is described wrongly is told so, and any other goes on to the search."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.effects import effect_named
from omnimate.mismatch import diagnose
from omnimate.mismatch.description.first_look import WIRINGS, Look, Wiring, first_look
from omnimate.mismatch.report.page import render
from omnimate.motion.paths import figure_eight
from omnimate.vcan_sim.reference import reference_single
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.odometry import dead_reckon
from omnimate.vehicle.parameters import Truck
from omnimate.vehicle.recording import Poses
from studies.datasets import husky, labyrinth


@pytest.fixture(scope="module")
def drive():
    """A single truck on figures of eight, with its true poses every tenth of a second."""
    vehicle = reference_single()
    return watched(simulate(vehicle, Truth(vehicle, seed=3), figure_eight(0.6, 1)))


def watched(recording):
    path, every = dead_reckon(recording), slice(None, None, 10)
    count = len(path[every])
    return replace(
        recording,
        poses=Poses(
            recording.time[every].copy(), np.full(count, "a"), path[every].copy(), np.full((count, 3), 1e-3)
        ),
    )


def described(recording, wiring=WIRINGS[0], wheelbase=1.0):
    """Return a recording whose vehicle is described with a wrong wiring and wheelbase."""
    vehicle = recording.vehicle
    truck = vehicle.trucks["a"]
    wrong = Truck(wheelbase * truck.wheelbase, truck.wheel_diameter_left, truck.wheel_diameter_right)
    encoders = tuple(wiring.rewired(one, "a") for one in vehicle.encoders)
    return replace(recording, vehicle=replace(vehicle, encoders=encoders).with_truck("a", wrong))


def without_headings(recording):
    poses = recording.poses
    pose = np.column_stack([poses.pose[:, :2], np.full(len(poses.time), np.nan)])
    return replace(recording, poses=Poses(poses.time, poses.body, pose, poses.sigma))


def test_a_robot_as_its_owner_believes_is_not_doubted(drive):
    assert first_look([drive]) is None
    assert first_look([without_headings(drive)]) is None


@pytest.mark.parametrize("wiring", WIRINGS[1:], ids=str)
def test_every_wrong_wiring_is_found_where_headings_are_measured(drive, wiring):
    look = first_look([described(drive, wiring)])
    right = look.corrected(described(drive, wiring)).vehicle.encoders
    assert [(one.channel, one.sign) for one in right] == [
        (one.channel, one.sign) for one in drive.vehicle.encoders
    ]
    assert look.probability > 0.9
    assert look.equals == ()


@pytest.mark.slow
def test_positions_without_headings_leave_two_wirings_and_both_are_told(drive):
    recording = without_headings(described(drive, Wiring(exchanged=True), wheelbase=0.5))
    look = first_look([recording])
    assert {look.wiring, *look.equals} == {Wiring(exchanged=True), Wiring(backward=(True, True))}
    says = diagnose([recording]).says
    assert "left and right are exchanged" in says
    assert "both wheels count backwards" in says


@pytest.mark.parametrize("ratio", [0.4, 0.7, 1.6, 2.5])
def test_a_wheelbase_far_off_is_named_with_its_size_and_no_wheel_beside_it(drive, ratio):
    recording = described(drive, wheelbase=1.0 / ratio)
    diagnosis = diagnose([recording])
    assert [(one.effect, one.component) for one in diagnosis.findings] == [("wheelbase", "a")]
    assert diagnosis.findings[0].parameters[0].value == pytest.approx(ratio, rel=0.01)
    assert diagnosis.fit.heldout.after < 1.5 < diagnosis.fit.heldout.before


def test_a_number_that_nobody_mistakes_explains_nothing_however_near_it_leads():
    look = Look("a", WIRINGS[0], (), 0.99, 0.0, np.ones(3), np.zeros(3), 0.02, 0.002, 0.002, np.ones(4))
    assert replace(look, ratios=np.array([1.0, 1.0, 2.6])).wrong
    assert not replace(look, ratios=np.array([1.07, 0.94, 12.2])).wrong
    assert not replace(look, ratios=np.array([1.0, 0.3, 1.0])).wrong


def test_the_answer_has_its_report_and_its_json(drive):
    diagnosis = diagnose([described(drive, Wiring(exchanged=True))])
    assert "described wrongly" in render(diagnosis)
    assert diagnosis.as_json()["findings"][0]["effect"] == "unknown"


def test_small_effects_are_left_to_the_search(drive):
    vehicle = drive.vehicle
    worn = effect_named("wheel_diameter")("a.left", ratio=1.02)
    recording = watched(simulate(vehicle, Truth(vehicle, seed=3, effects=(worn,)), figure_eight(0.6, 1)))
    assert first_look([recording]) is None


def test_where_the_world_is_turned_makes_no_difference_to_positions_without_headings(drive):
    recording = without_headings(drive)
    pose = recording.poses.pose.copy()
    pose[:, :2] = pose[:, :2] @ np.array([[-0.6, 0.8], [-0.8, -0.6]])
    turned = replace(recording, poses=replace(recording.poses, pose=pose))
    straight, other = (diagnose([one]).fit.heldout.before for one in (recording, turned))
    assert other == pytest.approx(straight, rel=0.05)


def test_labyrinth_has_its_wheels_exchanged_and_half_of_its_wheelbase(shared_data):
    diagnosis = diagnose(list(dict(labyrinth.each_recording(shared_data / "real/labyrinth_tuc")).values()))
    assert [(one.effect, one.component) for one in diagnosis.findings] == [
        ("unknown", "a"),
        ("wheelbase", "a"),
    ]
    assert "left and right are exchanged" in diagnosis.says
    assert diagnosis.findings[1].parameters[0].value == pytest.approx(1.97, abs=0.1)
    assert diagnosis.fit.heldout.after < 0.2 * diagnosis.fit.heldout.before


def test_husky_turns_as_if_it_were_twice_as_wide_and_slips_or_has_smaller_wheels(shared_data):
    diagnosis = diagnose(list(dict(husky.each_recording(shared_data / "real/drive_ugv")).values())[::10])
    assert diagnosis.findings[0].effect == "wheelbase"
    assert diagnosis.findings[0].parameters[0].value == pytest.approx(2.1, abs=0.25)
    assert all(one.probability <= 0.5 for one in diagnosis.findings[1:])
    assert diagnosis.fit.heldout.after < 0.7 * diagnosis.fit.heldout.before
