"""Least squares over any drive: unbiased, with intervals that hold what they promise, and not misled."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.calib.errors import CalibrationError, UnobservableError
from omnimate.calib.estimation.chains import Chains
from omnimate.calib.paths.drives import Drive
from omnimate.calib.paths.kinematics import Differential
from omnimate.calib.paths.least_squares import calibrate_path, calibrate_truck
from omnimate.motion.paths import figure_eight, free, out_and_back, squares, umbmark
from omnimate.vcan_sim.floor import SMOOTH
from omnimate.vcan_sim.reference import reference_single, reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth, uncalibrated
from omnimate.vehicle.arcs import integrate
from omnimate.vehicle.parameters import Truck
from omnimate.vehicle.se2 import compose, wrap
from omnimate.vehicle.sonar import Sonar
from studies.datasets.optiodom.drives import Tricycle

NOMINAL = Truck(0.340, 0.150, 0.150)
TRUE = np.array([np.log(336.17 / 340.0), 0.0, np.log(1.00084)])
ROUGHNESS, NOISE = 5e-4, np.array([2e-3, 2e-3, 4e-3])


def dense_drive(
    model, coordinates, readings, *, every=4, seed=0, lever=(0.0, 0.0, 0.0), delay=0.0, roughness=ROUGHNESS
):
    """Return a drive at 20 Hz whose every `every`-th pose was measured with noise and no stated sigma."""
    chance = np.random.default_rng(seed)
    steps = model.steps(readings, coordinates)
    spread = roughness**2 * steps.noise[:, 0] + 1e-18 * np.eye(3)
    error = (np.linalg.cholesky(spread) @ chance.standard_normal((len(spread), 3, 1)))[:, :, 0]
    path = integrate(compose(steps.increment, error), (1.0, 2.0, 0.5))
    clock = 0.05 * np.arange(len(readings))
    pose = compose(path[::every], lever)
    pose = pose + chance.standard_normal(pose.shape) * NOISE
    pose[:, 2] = wrap(pose[:, 2])
    return Drive(clock, readings, clock[::every] - delay, pose, np.full(pose.shape, np.nan), f"seed {seed}")


def wandering(seconds=300.0, seed=0):
    """Return wheel angles `(N, 2)` of a drive with straights, curves and spins, about 0.3 m/s."""
    chance = np.random.default_rng(seed)
    rate = np.repeat(chance.uniform([1.0, -2.0], [6.0, 2.0], (int(seconds / 3), 2)), 60, axis=0)
    wheels = np.stack([rate[:, 0] - rate[:, 1], rate[:, 0] + rate[:, 1]], axis=-1)
    return np.vstack([np.zeros((1, 2)), np.cumsum(wheels * 0.05, axis=0)])


def scores(found, truth):
    """Return the errors in standard deviations, of what was estimated."""
    free = found.sigma > 0.0
    return ((found.coordinates - truth)[free]) / found.sigma[free]


@pytest.fixture(scope="module")
def robot():
    return reference_single()


def truth_of(robot, seed, **changes):
    return Truth(uncalibrated(robot), seed=seed, **changes)


@pytest.mark.parametrize(
    "program", [umbmark(4.0, 3), free(1, 3), figure_eight(1.0, 4)], ids=lambda one: one.protocol
)
def test_any_drive_with_fixes_at_the_stops_gives_the_truth_back_on_a_smooth_floor(robot, program):
    true = truth_of(robot, 0, floor=SMOOTH, sonar=Sonar(sigma=1e-5))
    found = calibrate_truck([simulate(robot, true, program)], hold=["mean diameter (E_s)"])
    np.testing.assert_allclose(found.estimate.coordinates, TRUE, atol=3e-5)


@pytest.mark.slow
def test_intervals_of_95_per_cent_hold_the_truth_as_often(robot):
    """UMBmark with two and two runs on concrete: 25 experiments, wheelbase and E_d, roughness estimated."""
    inside, errors = [], []
    for seed in range(25):
        found = calibrate_truck([simulate(robot, truth_of(robot, seed), umbmark(4.0, 2))])
        names = {one.name: one for one in found.quantities}
        wheelbase = names["wheelbase"]
        errors.append(scores(found.estimate, TRUE))
        inside += list(np.abs(errors[-1]) < found.estimate.half_width)
        assert (wheelbase.low < 0.33617 < wheelbase.high) == inside[-2]
    assert np.mean(inside) >= 0.84  # 50 draws of 0.95: three and a half sigma below
    assert np.abs(np.mean(errors, axis=0)).max() < 3.5 / np.sqrt(25)


def test_dense_poses_give_intervals_that_hold_too():
    """Everything estimated at once: truck, mounting offset, clock, roughness, pose noise."""
    lever, delay = (0.05, -0.02, 0.03), 0.03
    truth = np.array([*TRUE, *lever, delay])
    errors = []
    for seed in range(6):
        drive = dense_drive(
            Differential(NOMINAL), TRUE, wandering(90.0, seed), seed=seed, lever=lever, delay=delay, every=8
        )
        found = calibrate_path([drive], Differential(NOMINAL), with_offset=True, with_time=True, spacing=0.0)
        errors.append(scores(found.estimate, truth))
    assert np.std(errors) == pytest.approx(1.0, abs=0.25)
    assert np.mean(np.abs(errors) < 1.96) > 0.86


def test_the_noise_is_found_beside_the_parameters():
    drive = dense_drive(Differential(NOMINAL), TRUE, wandering(), every=4)
    found = calibrate_path([drive], Differential(NOMINAL), spacing=0.0).estimate
    noises = {one.source.name: one.value for one in found.noises}
    assert noises["roughness"] == pytest.approx(ROUGHNESS, rel=0.25)
    assert noises["pose position"] == pytest.approx(2e-3, rel=0.1)
    assert noises["pose heading"] == pytest.approx(4e-3, rel=0.1)
    assert found.rms == pytest.approx(1.0, abs=0.05)


def test_five_minutes_at_20_hz_need_few_passes_over_few_poses(monkeypatch):
    """A budget that does not depend on the machine: poses that are used, and passes over them."""
    passes = []
    filtered = Chains.filtered
    monkeypatch.setattr(Chains, "filtered", lambda *arguments: passes.append(1) or filtered(*arguments))
    drive = dense_drive(Differential(NOMINAL), TRUE, wandering(300.0), every=1)
    found = calibrate_path([drive], Differential(NOMINAL), with_offset=True)
    assert found.estimate.fixes <= 151
    assert len(passes) <= 40
    np.testing.assert_allclose(
        found.estimate.coordinates[:3], TRUE, atol=4.0 * found.estimate.sigma[:3].max()
    )


def test_a_wild_fix_alone_is_named_and_does_no_harm(robot):
    recording = simulate(robot, truth_of(robot, 2), umbmark(4.0, 4))
    clean = calibrate_truck([recording])
    assert clean.estimate.down_weighted == ()
    pose = recording.poses.pose.copy()
    pose[7] += [1.0, -0.7, 0.3]
    old = recording.poses
    spoiled = replace(recording, poses=replace(old, pose=pose))
    found = calibrate_truck([spoiled])
    assert [round(one.time, 6) for one in found.estimate.down_weighted] == [round(float(old.time[7]), 6)]
    assert found.estimate.down_weighted[0].weight < 0.02
    away = (found.estimate.coordinates - clean.estimate.coordinates) / np.maximum(clean.estimate.sigma, 1e-9)
    assert np.abs(away).max() < 1.0


def test_positions_without_headings_are_enough():
    drive = dense_drive(Differential(NOMINAL), TRUE, wandering(120.0), every=10)
    pose = drive.pose.copy()
    pose[:, 2] = np.nan
    found = calibrate_path([replace(drive, pose=pose)], Differential(NOMINAL), spacing=0.0)
    assert np.abs(scores(found.estimate, TRUE)).max() < 4.0
    assert found.estimate.sigma[0] > 0.0


def test_truck_b_in_the_parallel_formation_is_not_biased():
    """Its squares are none by its own odometry: the chain's inversion takes 4 to 7 % off, this does not."""
    robot, errors = reference_vehicle(), []
    truth = np.array([-TRUE[0], 0.0, -TRUE[2]])
    for seed in range(8):
        recording = simulate(robot, truth_of(robot, seed), umbmark(4.0, 3, link_length=1.0))
        errors.append(calibrate_truck([recording], "b").estimate.coordinates[[0, 2]] / truth[[0, 2]] - 1.0)
    mean, spread = np.mean(errors, axis=0), np.std(errors, axis=0, ddof=1) / np.sqrt(8)
    assert np.all(np.abs(mean) < 3.0 * spread)
    assert 1.5 * spread[0] < 0.04  # so that a bias of 4 to 7 % would show


def test_closed_squares_do_not_tell_e_s(robot):
    found = calibrate_truck([simulate(robot, truth_of(robot, 0), umbmark(4.0, 5))])
    assert [one.name for one in found.estimate.held] == ["mean diameter (E_s)"]
    assert found.truck.wheel_diameter_left + found.truck.wheel_diameter_right == pytest.approx(0.3)


def test_a_straight_drive_out_and_back_tells_nothing(robot):
    with pytest.raises(UnobservableError) as caught:
        calibrate_truck([simulate(robot, truth_of(robot, 0), out_and_back(10.0, 1))])
    assert "wheelbase" in caught.value.reasons


def test_squares_of_one_direction_do_not_tell_the_wheelbase_from_the_ratio(robot):
    drives = [
        simulate(robot, truth_of(robot, seed), squares(["ccw"])) for seed in range(3)
    ]  # one lap each: the drive home between laps would tell a little more
    with pytest.raises(UnobservableError) as caught:
        calibrate_truck(drives)
    assert "combination of wheelbase and diameter ratio" in str(caught.value)


def test_open_straights_alone_hold_the_wheelbase_and_tell_the_diameters():
    readings = np.linspace(0.0, 180.0, 1200)[:, np.newaxis] * np.ones((1, 2))
    drive = dense_drive(Differential(NOMINAL), np.array([0.0, 0.004, 0.0]), readings, every=60)
    found = calibrate_path([drive], Differential(NOMINAL))
    assert [one.name for one in found.estimate.held] == ["wheelbase"]
    wheelbase, *diameters = found.quantities
    assert wheelbase.value == wheelbase.nominal
    assert np.isnan([wheelbase.sigma, wheelbase.low, wheelbase.high]).all()  # no interval of width 0
    assert all(one.low < one.value < one.high for one in diameters)
    assert found.estimate.coordinates[1] == pytest.approx(0.004, abs=4.0 * found.estimate.sigma[1])


def test_a_tricycle_is_calibrated_by_the_same_law():
    nominal, truth = Tricycle(0.15, 0.065), np.array([0.04, -0.01, -0.02])
    chance = np.random.default_rng(3)
    rolled = np.concatenate(([0.0], np.cumsum(np.full(3600, 0.2))))
    steered = np.interp(np.arange(3601), np.arange(0, 3700, 100), chance.uniform(-0.5, 0.5, 37))
    drive = dense_drive(nominal, truth, np.stack([rolled, steered], axis=-1), every=20)
    found = calibrate_path([drive], nominal, spacing=1.0)
    assert np.abs(scores(found.estimate, truth)).max() < 4.0
    np.testing.assert_allclose(found.estimate.coordinates, truth, atol=6e-3)


def test_a_name_that_cannot_be_held_is_refused(robot):
    recording = simulate(robot, truth_of(robot, 0), umbmark(4.0, 1))
    with pytest.raises(CalibrationError, match=r"cannot hold E_s.*mean diameter"):
        calibrate_truck([recording], hold=["E_s"])
