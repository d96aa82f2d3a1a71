"""Recordings in order of time: a robot that wore out is distinguished from one that did not."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.calib.errors import CalibrationError
from omnimate.calib.monitoring.drift import MIN_VALUES, monitor_drift
from omnimate.motion.paths import out_and_back, rounded_rectangle, umbmark
from omnimate.vcan_sim.floor import Floor
from omnimate.vcan_sim.reference import reference_single, reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth, with_errors

ROBOT = reference_vehicle()
WORN = with_errors(ROBOT, {"a": 1.01}, {"a": 1.003})


def squares(seed, true=ROBOT, day=0, robot=ROBOT, runs=8):
    truth = Truth(true, floor=Floor(), seed=seed)
    link = None if robot.linkage is None else robot.linkage.length
    program = umbmark(1.5, runs, speed=0.4, link_length=link)
    return simulate(robot, truth, program, start_time=1.7e9 + 86400.0 * day)


@pytest.fixture(scope="module")
def healthy():
    return [squares(1), squares(2, day=1)]


@pytest.mark.slow
def test_a_robot_that_wore_out_is_reported_with_the_lap_from_which_on(healthy):
    """16 laps in each direction, then 8 of the worn robot; the order in which they are given is no matter."""
    worn = squares(3, WORN, day=2)
    report = monitor_drift([worn, *healthy])
    assert report.alarms
    assert report.alarms[0].name.startswith("return")
    assert "truck a" in report.alarms[0].name
    assert abs(report.alarms[0].since - 17) <= 2
    before, after = report.alarms[0].means
    assert abs(after - before) > 0.01


def test_a_healthy_robot_raises_no_alarm(healthy):
    report = monitor_drift(healthy)
    assert (report.alarms, report.has_enough_values, report.used, report.left_out) == ((), True, 2, 0)
    assert report.apart == ()


def test_a_lap_with_a_wrong_fix_is_named_and_is_no_drift(healthy):
    last = healthy[-1]
    pose = last.poses.pose.copy()
    pose[-1, :2] += 0.5
    wrong = replace(last, poses=replace(last.poses, pose=pose))
    report = monitor_drift([*healthy[:-1], wrong])
    assert report.alarms == ()
    assert len(report.apart) == 1
    assert f"lap {len(last.run.laps)}, truck" in report.apart[0]


def test_what_was_before_the_last_calibration_is_left_out(healthy):
    calibrated = WORN
    report = monitor_drift([*healthy, squares(3, WORN, day=2, robot=calibrated, runs=1)])
    assert (report.used, report.left_out, report.has_enough_values, report.alarms) == (1, 2, False, ())


def test_working_days_without_fixes_show_drift_by_what_the_filter_learns():
    """Two numbers a truck from each recording; after 8 healthy days, 8 with a wheelbase 1 % wider.

    A lap in one direction alone does not tell a wheelbase from unequal wheels.
    """
    path = rounded_rectangle(3.0, 2.0, ["ccw", "cw"])
    days = []
    for day in range(2 * MIN_VALUES + 4):
        true = ROBOT if day < MIN_VALUES + 2 else WORN
        truth = Truth(true, floor=Floor(), seed=day)
        recording = simulate(ROBOT, truth, path, start_time=1.7e9 + 86400.0 * day)
        days.append(replace(recording, poses=None, run=None))
    report = monitor_drift(days[: MIN_VALUES + 2])
    assert {len(quantity.values) for quantity in report.quantities} == {MIN_VALUES + 2}
    assert report.has_enough_values
    assert not report.alarms
    assert len(report.quantities) == 4
    alarms = {alarm.name: alarm for alarm in monitor_drift(days).alarms}
    found = alarms["wheelbase of truck a beside the file, by the linkage"]
    assert all("truck a" in name for name in alarms)
    assert abs(found.since - (MIN_VALUES + 3)) <= 2
    assert np.diff(found.means) == pytest.approx(0.01, rel=0.4)


def test_recordings_count_only_for_what_they_identify():
    """A robot that stands shows nothing, one that drives straight no wheelbase: neither is `fine` by them."""
    path = out_and_back(3.0, 1)
    drives = []
    for day in range(MIN_VALUES):
        truth = Truth(ROBOT, floor=Floor(), seed=day)
        recording = simulate(ROBOT, truth, path, start_time=1.7e9 + 86400.0 * day)
        drives.append(replace(recording, poses=None, run=None))
    report = monitor_drift(drives)
    assert {quantity.name.split()[0] for quantity in report.quantities} == {"diameter"}
    standing = [replace(drive, counts=np.tile(drive.counts[:1], (len(drive), 1))) for drive in drives]
    report = monitor_drift(standing)
    assert not report.has_enough_values
    assert report.quantities == ()


def test_recordings_of_two_robots_are_refused(healthy):
    single = reference_single()
    with pytest.raises(CalibrationError, match="give recordings of one robot at a time"):
        monitor_drift([healthy[0], squares(1, single, day=1, robot=single, runs=1)])
