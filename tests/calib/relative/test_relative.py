"""Calibration by relative poses: robot and sensor are found, and what a drive cannot show is named."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.calib.errors import CalibrationError
from omnimate.calib.relative.calibration import calibrate_wheels
from omnimate.calib.relative.motions import COLUMNS, Motions, load_motions
from omnimate.vehicle.arcs import arc, integrate
from omnimate.vehicle.parameters import Truck
from omnimate.vehicle.se2 import between, compose

NOMINAL = Truck(0.34, 0.15, 0.15)
TRUE = Truck(0.347, 0.1506, 0.1493)
SENSOR = np.array([0.31, -0.12, 2.8])
SIGMA = np.array([0.003, 0.003, 0.002])
SAMPLES = 50  # of a motion


def drive(ways, turns, sensor=SENSOR, truck=TRUE, noise=None):
    """Return times, wheel angles and motions of a drive, one arc a second: way [m] and turn [rad] of each."""
    ways, turns = (np.repeat(np.asarray(each, float) / SAMPLES, SAMPLES) for each in (ways, turns))
    travel = np.column_stack([ways - 0.5 * truck.wheelbase * turns, ways + 0.5 * truck.wheelbase * turns])
    diameters = np.array([truck.wheel_diameter_left, truck.wheel_diameter_right])
    readings = np.concatenate([np.zeros((1, 2)), np.cumsum(travel / (0.5 * diameters), axis=0)])
    seen = compose(integrate(arc(travel[:, 0], travel[:, 1], truck.wheelbase))[::SAMPLES], sensor)
    pose = between(seen[:-1], seen[1:])
    if noise is not None:
        pose = compose(pose, SIGMA * noise.standard_normal(pose.shape))
    time = np.arange(len(readings)) / SAMPLES
    ends = time[::SAMPLES]
    return time, readings, Motions("drive", ends[:-1], ends[1:], pose, np.tile(SIGMA, (len(pose), 1)))


def curves(count, seed=0):
    chance = np.random.default_rng(seed)
    return chance.uniform(0.2, 0.6, count), chance.uniform(-1.0, 1.0, count)


def calibrated(driven, truck=NOMINAL):
    time, readings, motions = driven
    return calibrate_wheels(time, readings, truck, motions)


@settings(max_examples=20, deadline=None)
@given(x=st.floats(-0.5, 0.5), y=st.floats(-0.5, 0.5), yaw=st.floats(-3.1, 3.1), base=st.floats(0.33, 0.35))
def test_without_noise_all_six_numbers_are_found_wherever_the_sensor_sits(x, y, yaw, base):
    truck = Truck(base, 0.1503, 0.1498)
    found = calibrated(drive(*curves(60), np.array([x, y, yaw]), truck))
    assert found.truck.wheelbase == pytest.approx(base, abs=1e-7)
    assert found.truck.wheel_diameter_left == pytest.approx(0.1503, abs=1e-7)
    assert found.truck.wheel_diameter_right == pytest.approx(0.1498, abs=1e-7)
    assert found.sensor[:2] == pytest.approx([x, y], abs=1e-6)
    assert math.remainder(found.sensor[2] - yaw, math.tau) == pytest.approx(0.0, abs=1e-6)
    assert (found.estimate.held, found.missing_motion, found.outlying) == ((), None, 0)


def test_the_intervals_hold_the_truth_about_as_often_as_they_say():
    truth = np.array([TRUE.wheelbase, TRUE.wheel_diameter_left, TRUE.wheel_diameter_right, *SENSOR])
    held = []
    for seed in range(40):
        found = calibrated(drive(*curves(80, seed), noise=np.random.default_rng(seed)))
        held.append(
            [each.low <= true <= each.high for each, true in zip(found.quantities, truth, strict=True)]
        )
    assert np.mean(held) > 0.9


def test_motions_that_the_others_contradict_lose_weight():
    time, readings, motions = drive(*curves(120), noise=np.random.default_rng(3))
    motions.pose[::20] = compose(motions.pose[::20], [0.3, -0.2, 0.1])  # matched to another shelf
    found = calibrate_wheels(time, readings, NOMINAL, motions)
    assert found.outlying >= 6
    assert found.truck.wheelbase == pytest.approx(TRUE.wheelbase, abs=0.002)
    assert found.sensor[:2] == pytest.approx(SENSOR[:2], abs=0.01)


@pytest.mark.parametrize(
    ("ways", "turns", "words", "held"),
    [
        (np.full(60, 0.5), np.zeros(60), "straight ways only", {"wheelbase", "sensor x", "sensor y"}),
        (np.zeros(60), np.full(60, 0.8), "turning on the spot only", {"sensor yaw"}),
        (np.full(60, 0.5), np.full(60, 0.5), "one arc only, of 1.00 m to the left", set()),
        (np.full(60, 0.5), np.full(60, -0.5), "one arc only, of 1.00 m to the right", set()),
        (np.full(60, -0.5), np.full(60, -0.5), "one arc only, of 1.00 m to the left", set()),
    ],
)
def test_degenerate_motions_are_named_and_what_they_do_not_show_is_held(ways, turns, words, held):
    found = calibrated(drive(ways, turns, truck=NOMINAL))
    assert found.missing_motion.startswith(words)
    names = {single.name for single in found.estimate.held}
    assert names >= held
    assert names


def test_a_robot_that_stands_still_is_refused_with_what_to_drive():
    with pytest.raises(CalibrationError, match="stands still: drive arcs"):
        calibrated(drive(np.zeros(20), np.zeros(20)))


def test_curves_to_one_side_of_several_radii_suffice():
    chance = np.random.default_rng(1)
    found = calibrated(drive(chance.uniform(0.2, 0.6, 400), chance.uniform(0.2, 1.0, 400)))
    assert found.estimate.held == ()
    assert found.truck.wheelbase == pytest.approx(TRUE.wheelbase, abs=1e-6)


def test_motions_are_read_from_a_file(tmp_path):
    path = tmp_path / "relative.csv"
    lines = (",".join(COLUMNS), "0,1,0.5,0,0.1,0.003,0.003,0.002", "1,2,0.5,0,0.1,0.003,0.003,0.002")
    path.write_text("\n".join(lines), encoding="utf-8-sig")  # as spreadsheets write it
    motions = load_motions(path)
    assert motions.end.tolist() == [1.0, 2.0]
    assert motions.pose[1].tolist() == [0.5, 0.0, 0.1]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("start,end,x\n", "no column y, theta"),
        (",".join(COLUMNS) + "\n", "no relative pose"),
        (",".join(COLUMNS) + "\n0,1,a,0,0,1,1,1\n", "line 2: expected numbers"),
        (",".join(COLUMNS) + "\n1,0,0,0,0,1,1,1\n", "end after start"),
        (",".join(COLUMNS) + "\n0,1,0,0,0,1,0,1\n", "sigmas above 0"),
    ],
)
def test_a_file_that_is_none_is_refused_with_what_was_expected(tmp_path, text, words):
    path = tmp_path / "relative.csv"
    path.write_text(text)
    with pytest.raises(CalibrationError, match=words):
        load_motions(path)


def test_motions_outside_the_recording_or_out_of_order_are_refused():
    time, readings, motions = drive(*curves(20))
    with pytest.raises(CalibrationError, match="not within the"):
        calibrate_wheels(time[:-60], readings[:-60], NOMINAL, motions)
    late = Motions("drive", motions.start - 0.1, motions.end + 0.1, motions.pose, motions.sigma)
    with pytest.raises(CalibrationError, match="overlap"):
        calibrate_wheels(time, readings, NOMINAL, late)
    few = Motions("drive", *(each[:3] for each in (motions.start, motions.end, motions.pose, motions.sigma)))
    with pytest.raises(CalibrationError, match="3 relative poses"):
        calibrate_wheels(time, readings, NOMINAL, few)
