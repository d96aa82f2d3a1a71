"""The runner, with wheels that do exactly what they are told."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.motion.paths import figure_eight, out_and_back, rounded_rectangle, squares
from omnimate.motion.program import HERE, LINE, TURN, Program, ProgramError, Row, in_lap, rest
from omnimate.motion.runner import Runner
from omnimate.vehicle.arcs import advance
from omnimate.vehicle.parameters import Limits


def moved(vehicle, pose, left, right):
    """Return the pose of a single truck after a step at these wheel speeds [rad/s]."""
    truck, period = vehicle.trucks["a"], vehicle.bus.sync_period
    radii = 0.5 * truck.wheel_diameter_left, 0.5 * truck.wheel_diameter_right
    return advance(pose, left * radii[0] * period, right * radii[1] * period, truck.wheelbase)


def drive(vehicle, program, start=(0.0, 0.0, 0.0), most=20_000):
    """Work through a program on a perfect floor; return the commands and the poses of truck a."""
    runner, pose, commands, poses = Runner(program, vehicle), start, [], []
    for _ in range(most):
        wheels = runner.step(pose)
        commands.append(wheels)
        poses.append(pose)
        if runner.done:
            return np.array(commands), np.array(poses)
        pose = moved(vehicle, pose, *wheels)
    pytest.fail(f"not done after {most} steps, at {pose}")


def alone(*rows):
    return Program("free", tuple(in_lap(0, list(rows), HERE)), ("none",))


@settings(max_examples=20)
@given(length=st.floats(0.01, 5.0), speed=st.floats(0.05, 0.5), heading=st.floats(-3.0, 3.0))
def test_a_leg_ends_within_a_count_of_its_end_whatever_its_length(one_truck, length, speed, heading):
    start = (1.0, -2.0, heading)
    _, poses = drive(one_truck, alone(Row(LINE, x=length, speed=speed)), start)
    end = 1.0 + length * math.cos(heading), -2.0 + length * math.sin(heading)
    count = abs(one_truck.metres_per_count("a.right"))
    assert math.dist(poses[-1, :2], end) <= 1.01 * count
    along = (poses[:, :2] - poses[0, :2]) @ [math.cos(heading), math.sin(heading)]
    assert along.max() <= length + 1.01 * count


@settings(max_examples=20)
@given(angle=st.floats(-10.0, 10.0), speed=st.floats(0.05, 0.4))
def test_a_turn_of_any_angle_ends_within_its_tolerance_on_the_spot(one_truck, angle, speed):
    _, poses = drive(one_truck, alone(Row(TURN, heading=angle, speed=speed)))
    count = abs(one_truck.metres_per_count("a.right"))
    assert abs(poses[-1, 2] - angle) <= 2.02 * count / one_truck.trucks["a"].wheelbase
    assert np.hypot(poses[-1, 0], poses[-1, 1]) < 1e-9


PROGRAMS = {
    "square": lambda speed: squares(["cw"], 1.0, speed=speed),
    "straight": lambda speed: out_and_back(2.0, 1, speed=speed),
    "rectangle": lambda speed: rounded_rectangle(4.0, 2.0, ["ccw"], speed=speed),
    "eight": lambda speed: figure_eight(0.8, 1, speed=speed),
}


@settings(max_examples=30)
@given(
    name=st.sampled_from(sorted(PROGRAMS)),
    speed=st.floats(0.1, 1.0),
    limit=st.floats(0.1, 0.6),
    acceleration=st.floats(0.2, 1.0),
    period=st.sampled_from([0.005, 0.015, 0.04]),
)
def test_every_wheel_respects_its_speed_and_acceleration_over_a_whole_program(
    one_truck, name, speed, limit, acceleration, period
):
    vehicle = replace(
        one_truck,
        limits=Limits(limit, acceleration),
        bus=replace(one_truck.bus, sync_period=period),
    )
    commands, _ = drive(vehicle, PROGRAMS[name](speed), most=100_000)
    radius = [0.5 * vehicle.wheel_diameter(wheel) for wheel in vehicle.wheels]
    speeds = np.concatenate([np.zeros((1, 2)), commands * radius])
    assert np.abs(speeds).max() <= limit * (1.0 + 1e-9)
    assert np.abs(np.diff(speeds, axis=0)).max() <= acceleration * period * (1.0 + 1e-9)
    assert not commands[-1].any()


def test_a_wrapped_heading_is_followed_through_whole_turns(one_truck):
    runner, pose = Runner(alone(Row(TURN, heading=4.0 * math.pi, speed=0.3)), one_truck), (0.0, 0.0, 0.0)
    turned = 0.0
    while not runner.done:
        left, right = runner.step((pose[0], pose[1], math.remainder(pose[2], 2.0 * math.pi)))
        pose = moved(one_truck, pose, left, right)
        turned = max(turned, pose[2])
    assert turned == pytest.approx(4.0 * math.pi, abs=1e-3)


def test_laps_fixes_and_rest_can_be_seen_from_outside(one_truck):
    program = squares(["cw", "ccw"], 0.3)
    runner, pose, laps, fixes = Runner(program, one_truck), (0.0, 0.0, 0.0), [], 0
    assert (runner.lap, runner.done, runner.progress) == (None, False, 0.0)
    while not runner.done:
        left, right = runner.step(pose)
        if runner.fix_due:
            fixes += 1
            assert runner.at_rest
            assert runner.lap is None
        if not laps or laps[-1] != runner.lap:
            laps.append(runner.lap)
            assert runner.at_rest
        pose = moved(one_truck, pose, left, right)
    assert laps == [None, 0, None, 1, None]
    assert fixes == 4
    assert runner.progress == 1.0
    assert runner.step(pose) == (0.0, 0.0)


def test_a_robot_told_by_a_fix_where_it_is_drives_home_before_the_next_lap(one_truck):
    runner, pose = Runner(squares(["cw", "ccw"], 0.5), one_truck), (0.0, 0.0, 0.0)
    starts, fixes = [], 0
    while not runner.done:
        before = runner.lap
        left, right = runner.step(pose)
        if runner.lap is not None and before is None:
            starts.append(pose)
        if runner.fix_due:
            fixes += 1
            pose = (0.21, -0.18, -0.1) if fixes == 2 else pose
        pose = moved(one_truck, pose, left, right)
    assert np.abs(starts[1]).max() < 1e-3


def test_after_an_unplanned_stop_the_wheels_start_from_zero(one_truck):
    runner, pose = Runner(alone(Row(LINE, x=3.0, speed=0.4)), one_truck), (0.0, 0.0, 0.0)
    for step in range(200):
        wheels = runner.step((0.005 * step, 0.0, 0.0))
    assert min(wheels) * 0.075 > 0.3
    assert runner.halt() == (0.0, 0.0)
    assert max(runner.step(pose)) * 0.0755 <= 0.5 * 0.015 * 1.01


def test_a_rest_lasts_as_long_as_it_says(one_truck):
    program = Program("free", (rest(1.5),), ())
    commands, _ = drive(one_truck, program)
    assert len(commands) * 0.015 == pytest.approx(1.5, abs=0.03)


def test_two_trucks_without_a_reading_of_the_linkage_are_refused(two_trucks):
    with pytest.raises(ValueError, match="linkage"):
        Runner(out_and_back(1.0, 1), two_trucks).step((0.0, 0.0, 0.0))


def test_a_program_that_moves_a_truck_that_is_not_there_is_refused(one_truck):
    with pytest.raises(ProgramError, match=r"moves truck b; .* has truck a alone"):
        Runner(squares(["cw", "ccw"], 1.0, link_length=1.0), one_truck)
