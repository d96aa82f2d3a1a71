"""From recordings to findings, on simulated robots and on recordings of a simulator that is not ours."""

import json
import sys
from dataclasses import replace

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from omnimate.effects.file import format_effects, parse_effects
from omnimate.files.recordings.folder import load_recording
from omnimate.mismatch import diagnose
from omnimate.motion.paths import out_and_back, umbmark
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.errors import RecordingError
from omnimate.vehicle.odometry import dead_reckon
from omnimate.vehicle.recording import Poses
from tests.samples import SHARED_DATA

CONCEALED = SHARED_DATA / "concealed"
SINGLE = (
    ("wheel_diameter", "a.left", "ratio", 1.004),
    ("wheelbase", "b", "ratio", 1.02),
    ("joint_bias", "joint_a", "bias", 0.02),
    ("wheel_eccentricity", "a.right", "amplitude", 1e-3),
    ("latency", "joint_b", "delay", 0.06),
    ("latency", "joint_b", "delay", 0.13),
)


def names(diagnosis):
    return [(finding.effect, finding.component) for finding in diagnosis.findings]


def test_a_robot_as_its_owner_believes_agrees_and_nothing_that_was_left_changes_it(diagnosed):
    diagnosis = diagnosed()
    assert diagnosis.verdict == "agreement"
    assert diagnosis.as_json()["traces"] == []
    assert diagnosis.fit.heldout.before == pytest.approx(1.0, abs=0.1)
    assert diagnosis.fit.heldout.after <= diagnosis.fit.heldout.before


@pytest.mark.parametrize(("name", "component", "parameter", "value"), SINGLE)
def test_a_single_effect_is_named_with_its_size(diagnosed, effect, name, component, parameter, value):
    diagnosis = diagnosed(effect(name, component, **{parameter: value}))
    assert diagnosis.verdict == "mismatch"
    assert names(diagnosis) == [(name, component)]
    told = next(single for single in diagnosis.findings[0].parameters if single.name == parameter)
    assert abs(told.value - value) < 4.0 * told.sigma


def test_a_worn_wheel_helps_on_laps_that_it_has_not_seen(diagnosed, effect):
    fit = diagnosed(effect("wheel_diameter", "a.left", ratio=1.004)).fit
    assert fit.heldout.after < 1.05 < fit.heldout.before
    assert fit.gain[0] > 3.0 * fit.gain[1] > 0.0
    assert fit.rerun["joint_a"].after < 0.6 * fit.rerun["joint_a"].before


@pytest.mark.slow
def test_what_is_left_out_of_the_library_is_not_named_and_nothing_wrong_is(drive, effect):
    gone = ["wheel_diameter", "radius_vs_speed", "count_loss", "radius_step"]
    diagnosis = diagnose([drive(effect("wheel_diameter", "a.left", ratio=1.004))], without=gone)
    assert not {effect for effect, _ in names(diagnosis)} & set(gone)
    assert names(diagnosis)[0] == ("unknown", "a.left")


def test_two_effects_at_once_are_told_apart(diagnosed, effect):
    both = effect("joint_bias", "joint_a", bias=0.02), effect("wheelbase", "b", ratio=1.02)
    diagnosis = diagnosed(*both)
    assert set(names(diagnosis)) == {("joint_bias", "joint_a"), ("wheelbase", "b")}
    effects = {(single.name, single.component) for single in diagnosis.effects}
    assert effects == set(names(diagnosis))


def test_bumps_are_found_where_they_are(diagnosed, effect):
    diagnosis = diagnosed(effect("bump", "b.right", times=(20.0, 55.0), lost=(3e-3, 3e-3)))
    finding = diagnosis.findings[0]
    assert finding.key == ("bump", "b.right")
    onsets = [start for start, _ in finding.where.intervals]
    np.testing.assert_allclose(onsets, (20.0, 55.0), atol=0.15)
    assert finding.where.laps == (0, 1)


def test_a_straight_drive_that_cannot_show_the_wheelbases_is_insufficient():
    vehicle = reference_vehicle()
    diagnosis = diagnose([simulate(vehicle, Truth(vehicle, seed=3), out_and_back(2.0, 1))])
    assert diagnosis.verdict == "insufficient"
    assert "wheelbase" in diagnosis.says
    assert any("turns on the spot" in drive for drive in diagnosis.drive_next)


def test_the_effects_found_go_through_their_file(diagnosed, effect):
    diagnosis = diagnosed(effect("wheel_diameter", "a.left", ratio=1.004))
    assert parse_effects(format_effects(diagnosis.effects)) == diagnosis.effects


@pytest.mark.slow
@pytest.mark.skipif(not CONCEALED.is_dir(), reason="../shared/data/concealed is not there")
@pytest.mark.parametrize("name", ["6e57128b", "f66eb555", "93d39ee1"])
def test_recordings_of_another_simulator_get_a_right_answer(name):
    label = json.loads((CONCEALED / "labels.json").read_text())[name]
    diagnosis = diagnose([load_recording(CONCEALED / name / single) for single in label["recordings"]])
    assert diagnosis.verdict in label["verdict"]
    for truth in label["effects"] if diagnosis.verdict == "mismatch" else ():
        right = {(single["effect"], single["component"]) for single in [truth, *truth["acceptable"]]}
        assert right & set(names(diagnosis))


def test_a_search_that_is_ended_by_its_budget_still_answers_and_says_so(drive, effect, monkeypatch):
    monkeypatch.setattr(sys.modules["omnimate.mismatch.investigate"], "MIN_ROUNDS", 1)
    answer = diagnose([drive(effect("wheel_diameter", "a.left", ratio=1.01))], budget=0.0)
    assert answer.verdict == "mismatch"
    assert "budget" in answer.says
    assert answer.as_json()["complete"] is False


def test_matrices_have_one_thread_until_the_answer_is_there(drive, effect):
    def threads():
        return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}

    seen = []
    with threadpool_limits(2, user_api="blas"):
        diagnose(
            [drive(effect("wheel_diameter", "a.left", ratio=1.01))],
            budget=0.0,
            progress=lambda _done, _all, doing: seen.append((doing, threads())),
        )
        assert threads() == {2}
    assert dict(seen)["comparing sets of effects"] == {1}


def test_a_wheel_that_warms_up_is_no_wrong_diameter(diagnosed, effect):
    warming = effect("law", "a.left", acts_on="travel", formula="0.006 * (1 - exp(-way / 8))")
    (finding,) = diagnosed(warming).findings
    assert finding.key == ("unknown", "a.left")
    assert finding.depends_on == ("time",)
    assert "+0." in finding.says


@pytest.mark.parametrize("at", ["all along", "stops"])
def test_poses_in_other_units_are_refused_with_the_recording_and_the_units_expected(at):
    vehicle = reference_vehicle()
    drive = simulate(vehicle, Truth(vehicle, seed=1), umbmark(1.0, 1, link_length=1.0))
    poses = drive.poses
    if at == "all along":
        time = drive.time[::50]
        known = np.full((len(time), 3), np.nan)
        poses = Poses(time, np.full(len(time), "a"), dead_reckon(drive)[::50], known)
    wrong = replace(poses, pose=poses.pose * [1e3, 1e3, 180.0 / np.pi])
    with pytest.raises(RecordingError, match=r"simulation of omnimate: .*poses .* in metres"):
        diagnose([replace(drive, poses=wrong)])
