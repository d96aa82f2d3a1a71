"""From recordings to findings, on simulated robots and on recordings of a simulator that is not ours."""

import json
from pathlib import Path

import numpy as np
import pytest

from omnimate.logs.folder import load_recording
from omnimate.mismatch import diagnose
from omnimate.vcan_sim.effects.file import format_effects, parse_effects

CONCEALED = Path(__file__).resolve().parents[3] / "shared" / "data" / "concealed"


def names(diagnosis):
    return [(finding.effect, finding.component) for finding in diagnosis.findings]


def test_a_robot_as_its_owner_believes_agrees(drive):
    diagnosis = diagnose([drive()])
    assert diagnosis.verdict == "agreement"
    assert diagnosis.fit.heldout.before == pytest.approx(1.0, abs=0.1)


@pytest.fixture(scope="module")
def worn(drive, effect):
    return drive(effect("wheel_diameter", "a.left", ratio=1.004))


@pytest.fixture(scope="module")
def diagnosis(worn):
    return diagnose([worn])


def test_a_worn_wheel_is_named_with_its_size_and_helps_on_laps_that_it_has_not_seen(diagnosis):
    assert diagnosis.verdict == "mismatch"
    assert names(diagnosis) == [("wheel_diameter", "a.left")]
    ratio = diagnosis.findings[0].parameters[0]
    assert abs(ratio.value - 1.004) < 4.0 * ratio.sigma
    assert diagnosis.fit.heldout.after < 1.05 < diagnosis.fit.heldout.before
    assert diagnosis.fit.rerun["joint_a"].after < 0.6 * diagnosis.fit.rerun["joint_a"].before


def test_what_is_not_in_the_library_is_not_given_a_wrong_name(worn):
    diagnosis = diagnose([worn], without=["wheel_diameter", "radius_vs_speed", "count_loss", "radius_step"])
    assert diagnosis.findings[0].effect == "unknown"
    assert diagnosis.findings[0].component == "a.left"


def test_two_effects_at_once_are_told_apart(drive, effect):
    both = effect("joint_bias", "joint_a", bias=0.02), effect("wheelbase", "b", ratio=1.02)
    diagnosis = diagnose([drive(*both)])
    assert set(names(diagnosis)) == {("joint_bias", "joint_a"), ("wheelbase", "b")}
    assert {(one.name, one.component) for one in diagnosis.effects} == set(names(diagnosis))


def test_a_bump_is_found_to_the_sample(drive, effect):
    bump = effect("bump", "b.right", times=(20.0, 55.0), lost=(3e-3, 3e-3))
    recording = drive(bump)
    finding = diagnose([recording]).findings[0]
    assert (finding.effect, finding.component) == ("bump", "b.right")
    onsets = [start for start, _ in finding.where.intervals]
    np.testing.assert_allclose(onsets, (20.0, 55.0), atol=2.5 * recording.vehicle.bus.sync_period)


def test_the_effects_found_go_through_their_file(diagnosis):
    assert parse_effects(format_effects(diagnosis.effects)) == diagnosis.effects


def test_the_answer_is_the_contracts_object(diagnosis):
    answer = json.loads(json.dumps(diagnosis.as_json()))
    assert {"verdict", "findings", "fit", "unexplained"} <= answer.keys()
    finding = answer["findings"][0]
    assert {
        "effect",
        "component",
        "probability",
        "alternatives",
        "where",
        "parameters",
        "explained",
        "says",
    } <= finding.keys()
    assert {"channels", "intervals", "regime"} <= finding["where"].keys()
    assert {"metric", "train", "heldout"} <= answer["fit"].keys()


@pytest.mark.skipif(not CONCEALED.is_dir(), reason="../shared/data/concealed is not there")
@pytest.mark.parametrize("name", ["6e57128b", "7096976c", "f66eb555", "1f0a7196", "f1d637bd", "93d39ee1"])
def test_recordings_of_another_simulator_get_a_right_answer(name):
    label = json.loads((CONCEALED / "labels.json").read_text())[name]
    diagnosis = diagnose([load_recording(CONCEALED / name / one) for one in label["recordings"]])
    assert diagnosis.verdict in label["verdict"]
    for truth in label["effects"] if diagnosis.verdict == "mismatch" else ():
        right = {(one["effect"], one["component"]) for one in [truth, *truth["acceptable"]]}
        assert right & set(names(diagnosis))
