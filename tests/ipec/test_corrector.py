"""The correctors over whole recordings and live: equal, right without errors, robust to missing samples."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.ipec.corrector import METHODS, Corrector, correct
from omnimate.ipec.filter.estimate import estimate
from omnimate.motion.paths import free, rounded_rectangle, squares
from omnimate.vcan_sim.floor import SMOOTH, Floor, bumps_under
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.linkage import follower
from omnimate.vehicle.odometry import dead_reckon
from omnimate.vehicle.recording import Recording
from omnimate.vehicle.se2 import compose
from omnimate.vehicle.sonar import Sonar
from tests.ipec.conftest import thinned
from tests.recordings import samples

EXACT = Sonar(sigma=0.0)


START = np.array([3.0, -7.0, 2.0])


@pytest.fixture(scope="module")
def drive():
    robot = reference_vehicle()
    bumps = bumps_under("a.left", 3, 1.0, 6.0) + bumps_under("b.right", 3, 1.5, 6.0)
    return simulate(robot, Truth(robot, floor=Floor(bumps=bumps), seed=3), free(1, 1))


@pytest.mark.parametrize("method", METHODS)
def test_stepwise_and_at_once_give_the_same_poses_and_corrections(drive, method):
    """Also where readings are missing, and in a vehicle file with another order of channels."""
    turned = replace(drive.vehicle, encoders=drive.vehicle.encoders[::-1])
    recording = replace(thinned(drive), vehicle=turned)
    recording = Recording(turned, drive.time, recording.counts[:, ::-1], recording.present[:, ::-1])
    start = np.array([1.0, 2.0, 0.5])
    at_once = correct(recording, start, method=method)
    corrector = Corrector(turned, method)
    state = corrector.start(start)
    for index, sample in enumerate(samples(recording)):
        state = corrector.step(state, sample)
        assert np.array_equal(state.pose_a, at_once.pose_a[index])
        assert np.array_equal(state.pose_b, at_once.pose_b[index])
        assert state.corrections == tuple(at_once.corrections[index])


def test_a_step_leaves_the_state_before_it_as_it_was(drive):
    corrector = Corrector(drive.vehicle)
    stream = samples(drive)
    state = corrector.step(corrector.start(), next(stream))
    kept = state.record.tobytes()
    corrector.step(state, next(stream))
    assert state.record.tobytes() == kept
    with pytest.raises(ValueError, match="read-only"):
        state.record["pose"][0] = 0.0


@pytest.mark.parametrize("method", ["clapper", "omnimate"])
def test_a_consistent_linkage_corrects_nothing_and_ipec_equals_odometry(fine, method):
    recording = simulate(fine, Truth(fine, floor=SMOOTH), rounded_rectangle(3.0, 2.0, ["ccw"]))
    path = correct(recording, method=method)
    assert np.abs(path.corrections).max() < 2e-5  # a count of a wheel is 3.5e-5
    assert path.pose_a == pytest.approx(dead_reckon(recording, "a"), abs=3e-4)
    start_b = follower(np.zeros(3), recording.joint_angle("joint_a")[0], 0.0, recording.link_length()[0])
    assert path.pose_b == pytest.approx(dead_reckon(recording, "b", start_b), abs=5e-4)


def test_plain_is_dead_reckoning(drive):
    recording = thinned(drive)
    path = correct(recording, (1.0, -1.0, 2.0), method="plain")
    assert path.pose_a == pytest.approx(dead_reckon(recording, "a", (1.0, -1.0, 2.0)), abs=1e-9)
    assert not path.corrections.any()


@pytest.mark.parametrize("wheel", ["a.left", "a.right", "b.left", "b.right"])
@pytest.mark.parametrize("method", ["clapper", "omnimate"])
def test_ten_bumps_under_any_wheel_are_corrected(robot, lap_errors, wheel, method):
    """In turns the lost travel swings the link a little: a tenth of the error stays, C (7)."""
    floor = Floor(0.0, bumps_under(wheel, 10, 0.5, 6.5))
    truth = Truth(robot, floor=floor, sonar=EXACT)
    recording = simulate(robot, truth, rounded_rectangle(3.0, 2.0, ["cw"]))
    met = wheel[0]
    plain = lap_errors(recording, dead_reckon(recording, met), recording.poses.of(met))
    path = correct(recording, method=method)
    corrected = lap_errors(recording, path.pose_a if met == "a" else path.pose_b, recording.poses.of(met))
    assert abs(np.degrees(plain[0, 2])) == pytest.approx(5.5, abs=0.4)
    assert abs(corrected[0, 2]) < 0.1 * abs(plain[0, 2])
    assert np.hypot(*corrected[0, :2]) < 0.03


def test_missing_readings_do_not_look_like_bumps(robot, lap_errors):
    truth = Truth(robot, floor=SMOOTH, sonar=EXACT)
    recording = thinned(simulate(robot, truth, squares(["cw"], 1.0, link_length=1.0)), part=0.3)
    path = correct(recording)
    assert np.degrees(np.abs(path.corrections)).max() < 0.05
    assert abs(np.degrees(lap_errors(recording, path.pose_a)[0, 2])) < 0.1


@pytest.mark.parametrize("method", [correct, estimate])
def test_truck_b_is_unknown_until_the_linkage_is_read(drive, method):
    present = drive.present.copy()
    present[:5, 4] = False
    path = method(replace(drive, present=present))
    assert np.isnan(path.pose_b[:5]).all()
    assert np.isfinite(path.pose_b[5:]).all()


@pytest.mark.parametrize("method", METHODS)
def test_the_trajectory_from_another_start_is_the_same_one_moved(drive, method):
    here, there = correct(drive, method=method), correct(drive, START, method=method)
    assert there.pose_a == pytest.approx(compose(START, here.pose_a), abs=1e-6)
    assert there.corrections == pytest.approx(here.corrections, abs=1e-6)


@pytest.mark.parametrize("method", METHODS[1:])
def test_truck_b_is_at_the_link_length_behind_truck_a_in_every_sample(drive, method):
    path = correct(drive, method=method)
    distance = np.hypot(*(path.pose_a - path.pose_b)[:, :2].T)
    assert distance == pytest.approx(drive.link_length(), abs=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_a_robot_that_stands_stays_at_its_start(drive, method):
    counts = np.repeat(drive.counts[:1], 50, axis=0)
    still = Recording(drive.vehicle, drive.time[:50], counts, np.ones((50, 7), bool))
    path = correct(still, START, method=method)
    assert path.pose_a == pytest.approx(np.tile(START, (50, 1)), abs=1e-12)
    assert np.ptp(path.pose_b, axis=0) == pytest.approx([0.0] * 3, abs=1e-12)
