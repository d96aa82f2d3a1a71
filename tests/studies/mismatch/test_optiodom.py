"""The world of OptiOdom: halves of a set, plain least squares beside the effects found."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.effects.latency import Latency
from omnimate.effects.wheel_diameter import WheelDiameter
from omnimate.effects.wheelbase import Wheelbase
from omnimate.mismatch import Diagnosis
from studies.datasets.optiodom.drives import each_recording
from studies.mismatch.scoring.score import rows
from studies.mismatch.worlds import optiodom
from studies.mismatch.worlds.optiodom import diagnosed_and_driven, halves, position_error, write_optiodom
from studies.mismatch.worlds.world import Request

SET = "circular/250620202236"  # its nominal wheels are 1.6 % too large


@pytest.fixture(scope="module")
def runs(shared_data):
    return list(dict(each_recording(shared_data / "real/optiodom/diff" / SET)).values())


@pytest.fixture(scope="module")
def written(shared_data, tmp_path_factory):
    """Return the folder and the labels of the first set's two halves."""
    folder = tmp_path_factory.mktemp("optiodom")
    return folder, write_optiodom(shared_data, folder, Request(cases=2), 1, lambda *_: None)


def test_effects_that_calibrate_a_robot_predict_as_its_calibrated_description_does(runs):
    truck = runs[0].vehicle.trucks["a"]
    better = replace(
        truck, wheelbase=0.98 * truck.wheelbase, wheel_diameter_left=0.984 * truck.wheel_diameter_left
    )
    described = [replace(run, vehicle=run.vehicle.with_truck("a", better)) for run in runs]
    effects = WheelDiameter("a.left", 0.984), Wheelbase("a", 0.98)
    assert position_error(runs, effects) == pytest.approx(position_error(described), rel=1e-6)
    assert position_error(runs, effects) != pytest.approx(position_error(runs), rel=1e-3)


def test_poses_that_are_told_to_be_late_are_compared_with_the_time_that_they_are_of(runs):
    late = [replace(run, poses=replace(run.poses, time=run.poses.time + 0.3)) for run in runs]
    assert position_error(late) > 1.1 * position_error(runs)
    assert position_error(late, [Latency("poses", 0.3)]) == pytest.approx(position_error(runs), rel=0.02)


def test_halves_are_every_other_recording_and_a_single_one_is_cut(runs):
    first, second = halves(runs)
    assert [*first, *second] == [*runs[::2], *runs[1::2]]
    (begin,), (end,) = halves(runs[:1])
    assert len(begin) + len(end) == len(runs[0])
    assert begin.poses.time[-1] <= begin.time[-1] < end.poses.time[0]
    assert begin.run.laps[0].end <= begin.time[-1]


def test_labels_hold_what_least_squares_moves_by_five_sigma(written):
    _, labels = written
    assert set(labels) == {"circular-250620202104-1", "circular-250620202104-2"}
    for label in labels.values():
        assert {truth["effect"] for truth in label["effects"]} <= {"wheelbase", "wheel_diameter"}
        assert len(label["recordings"]) == len(label["held_out"]) == 3


def test_what_both_halves_together_say_is_true_of_each(written):
    _, labels = written
    first, second = (label["secondary"] for label in labels.values())
    assert first
    assert [truth["effect"] for truth in first] == [truth["effect"] for truth in second]
    ratios = [[truth["parameters"]["ratio"]["value"] for truth in label] for label in (first, second)]
    assert ratios[0] == pytest.approx(ratios[1])


def test_a_tool_that_finds_nothing_predicts_as_the_described_robot_and_asserts_nothing(written, monkeypatch):
    folder, written_labels = written
    labels = {name: {**label, "effects": label["secondary"]} for name, label in written_labels.items()}
    monkeypatch.setattr(optiodom, "diagnose", lambda _recordings: Diagnosis("agreement", "nothing"))
    answers = {name: diagnosed_and_driven((folder / name, label)) for name, label in labels.items()}
    errors = [answer["open_loop"] for answer in answers.values()]
    assert all(each["found"] == each["nominal"] for each in errors)
    table = {row.name: row for row in rows(labels, answers)}
    ratio = np.sqrt(sum(e["nominal"] ** 2 for e in errors) / sum(e["least squares"] ** 2 for e in errors))
    assert table["open loop over least squares, worst set"].value == pytest.approx(ratio)
    assert table["5 sigma by least squares: asserted"].value == 0.0
