"""Whole drives as arrays."""

import math
from dataclasses import replace

import numpy as np
import pytest

from omnimate.effects.crossing import cable_loss
from omnimate.motion.drive import LinkReader
from omnimate.motion.journal import Journal
from omnimate.motion.paths import figure_eight, free, out_and_back, rounded_rectangle, squares, umbmark
from omnimate.motion.program import LINE, Program, Row, rest
from omnimate.motion.runner import Runner
from omnimate.vcan_sim.errors import EndStopError, SimulationError
from omnimate.vcan_sim.floor import SMOOTH, Floor, bumps_under
from omnimate.vcan_sim.plant import Plant
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth, with_errors
from omnimate.vehicle.counters import counter_law, counters_of, take_readings
from omnimate.vehicle.odometry import Odometer, dead_reckon
from omnimate.vehicle.sample import Sample
from omnimate.vehicle.sonar import Sonar
from studies.papers.linkage_numbers import lap_errors


def wrong(vehicle, **truth):
    """The robot of U Fig. 11, whose truck b errs otherwise."""
    ratio_a, ratio_b = {"a": 336.17 / 340.0, "b": 1.004}, {"a": 1.00084, "b": 0.9995}
    names = vehicle.trucks
    true = with_errors(vehicle, {k: ratio_a[k] for k in names}, {k: ratio_b[k] for k in names})
    return Truth(true, **truth)


def return_errors(recording, truck):
    return lap_errors(recording, dead_reckon(recording, truck), recording.poses.of(truck))


def test_stepwise_and_at_once_give_the_same_counts_commands_laps_and_fixes(vehicle):
    truth, program = wrong(vehicle, seed=5), squares(["cw", "ccw"], 1.0, link_length=1.0)
    whole = simulate(vehicle, truth, program)
    plant, runner, journal = Plant(truth, vehicle), Runner(program, vehicle), Journal(program)
    counters = counters_of([counter_law(encoder, vehicle) for encoder in vehicle.encoders])
    odometer, reader, nothing = Odometer(vehicle), LinkReader(vehicle), (math.nan,) * 7
    for number, time in enumerate(whole.time):
        take_readings(counters, np.array(plant.raw_counts(), np.int64))
        counts = tuple(counters["count"].tolist())
        assert counts == tuple(whole.counts[number])
        pose = odometer.step(Sample(number, time, counts, (True,) * 7, nothing, nothing))
        speeds = runner.step(pose, reader.read(counts))
        assert speeds == tuple(whole.commands[number])
        journal.observe(time, runner)
        if runner.fix_due:
            for truck in ("a", "b"):
                journal.fix(time, truck, *plant.fix(truck))
            odometer.pose = tuple(journal.poses.of("a").pose[-1].tolist())
        plant.step(speeds, vehicle.bus.sync_period)
    assert runner.done
    assert journal.run == whole.run
    assert np.array_equal(journal.poses.pose, whole.poses.pose)


def test_the_seed_alone_makes_a_drive(alone):
    program = squares(["cw"], 1.0)
    first, same, other = (simulate(alone, wrong(alone, seed=seed), program) for seed in (1, 1, 2))
    assert np.array_equal(first.counts, same.counts)
    assert np.array_equal(first.poses.pose, same.poses.pose)
    assert not np.array_equal(first.poses.pose, other.poses.pose)


def test_the_recording_has_one_clock_laps_between_fixes_and_the_order_of_the_vehicle(vehicle):
    turned = replace(vehicle, encoders=vehicle.encoders[::-1])
    program = squares(["cw", "ccw"], 1.0, link_length=1.0)
    recording = simulate(turned, wrong(turned), program, start_time=1000.0)
    plain = simulate(vehicle, wrong(vehicle), program)
    assert np.array_equal(recording.counts, plain.counts[:, ::-1])
    assert np.diff(recording.time) == pytest.approx(0.015)
    assert recording.time[0] == 1000.0
    assert [lap.direction for lap in recording.run.laps] == ["cw", "ccw"]
    for truck in ("a", "b"):
        times = recording.poses.of(truck).time
        marks = [mark for lap in recording.run.laps for mark in (lap.start, lap.end)]
        assert len(times) == 4
        assert np.all((times[[0, 2]] < [marks[0], marks[2]]) & (times[[1, 3]] > [marks[1], marks[3]]))


def test_the_robot_stands_at_both_ends_of_a_lap_and_at_every_fix(vehicle):
    recording = simulate(vehicle, wrong(vehicle), squares(["cw", "ccw"], 1.0, link_length=1.0))
    marks = [mark for lap in recording.run.laps for mark in (lap.start, lap.end)]
    for time in [*marks, *recording.poses.time]:
        number = int(np.searchsorted(recording.time, time - 1e-6))
        assert not recording.commands[number - 1].any()
        assert np.array_equal(recording.counts[number], recording.counts[number - 1])


def test_without_errors_noise_and_roughness_odometry_is_right_to_its_resolution(vehicle):
    truth = Truth(vehicle, floor=SMOOTH, sonar=Sonar(sigma=0.0))
    recording = simulate(vehicle, truth, squares(["cw", "ccw"], 4.0, link_length=1.0))
    for truck in ("a", "b"):
        errors = return_errors(recording, truck)
        assert np.abs(errors[:, :2]).max() < 1e-3
        assert np.abs(errors[:, 2]).max() < 2e-4


def test_the_errors_of_figure_11_give_its_systematic_error(alone):
    """NOTES: b 336.17 of 340 mm and D_R/D_L 1.00084 make 311 mm by the exact chain."""
    truth = wrong(alone, floor=SMOOTH, sonar=Sonar(sigma=0.0))
    errors = return_errors(simulate(alone, truth, umbmark(runs=1)), "a")
    assert np.hypot(*errors[:, :2].T).max() == pytest.approx(0.311, abs=0.002)


@pytest.mark.parametrize("order", ["alternating", "grouped"])
def test_ten_laps_in_a_row_begin_within_three_centimetres_of_home(vehicle, order):
    program = umbmark(order=order, link_length=1.0)
    recording = simulate(vehicle, wrong(vehicle, seed=2), program)
    for truck, home in (("a", 0.0), ("b", -1.0)):
        starts = recording.poses.of(truck).pose[::2]
        assert len(starts) == 10
        assert np.abs(starts[:, 0] - home).max() < 0.03
        assert np.abs(starts[:, 1]).max() < 0.03
        assert np.degrees(np.abs(starts[:, 2]).max()) < 3.0


PROGRAMS = {
    "umbmark": lambda link: umbmark(runs=1, link_length=link),
    "straight": lambda link: out_and_back(18.0, 1, link_length=link),
    "clapper": lambda _: rounded_rectangle(7.0, 4.0, ["cw", "ccw"], tolerance=0.2, speed=0.45),
    "omnimate": lambda _: rounded_rectangle(6.0, 3.25, ["cw", "ccw"]),
    "free": lambda _: free(3, 2),
    "eight": lambda _: figure_eight(1.0, 2),
}


@pytest.mark.parametrize("name", PROGRAMS)
def test_two_wrong_trucks_drive_every_program_with_the_slider_in_its_stroke(vehicle, name):
    coarse = [
        replace(encoder, counts_per_turn=1024) if encoder.channel.startswith("joint") else encoder
        for encoder in vehicle.encoders
    ]
    robot = replace(vehicle, encoders=tuple(coarse))
    program = PROGRAMS[name](1.0)
    recording = simulate(robot, wrong(robot, seed=1), program)
    assert len(recording.run.laps) == len(program.directions)
    assert np.abs(recording.link_length() - 1.0).max() < 0.05
    start = recording.poses.of("a").pose[0]
    assert np.hypot(*(recording.poses.of("a").pose[-1] - start)[:2]) < 0.5
    radius = [0.5 * robot.wheel_diameter(wheel) for wheel in robot.wheels]
    assert np.abs(recording.commands * radius).max() <= robot.limits.speed * (1.0 + 1e-9)
    acceleration = np.abs(np.diff(recording.commands * radius, axis=0)).max() / 0.015
    assert acceleration <= robot.limits.acceleration * (1.0 + 1e-9)


@pytest.mark.parametrize("name", PROGRAMS)
def test_a_wrong_single_truck_drives_every_program(alone, name):
    program = PROGRAMS[name](None)
    recording = simulate(alone, wrong(alone, seed=1), program)
    assert len(recording.run.laps) == len(program.directions)
    assert recording.commands.shape[1] == 2


def test_like_a_car_truck_b_faces_truck_a_within_20_degrees(vehicle):
    recording = simulate(vehicle, wrong(vehicle), rounded_rectangle(7.0, 4.0, ["cw"], tolerance=0.2))
    assert np.degrees(np.abs(recording.joint_angle("joint_b")).max()) < 20.0


def test_in_formation_both_trucks_keep_one_heading_and_turn_whole_turns_against_the_deck(vehicle):
    recording = simulate(vehicle, wrong(vehicle), squares(["ccw"], 2.0, link_length=1.0))
    lap = recording.between(recording.run.laps[0].start, recording.run.laps[0].end)
    joint_a, joint_b = recording.joint_angle("joint_a")[lap], recording.joint_angle("joint_b")[lap]
    assert np.degrees(np.abs(joint_a - joint_b).max()) < 2.0
    assert np.degrees(joint_a[-1] - joint_a[0]) == pytest.approx(360.0, abs=8.0)


def test_bumps_of_one_lap_turn_the_robot_in_that_lap_alone(alone):
    bumps = bumps_under("a.right", 10, 0.0, 15.0, lap=1)
    truth = Truth(alone, floor=Floor(0.0, bumps), sonar=Sonar(sigma=0.0))
    errors = return_errors(simulate(alone, truth, squares(["ccw", "ccw", "ccw"], 4.0)), "a")
    turn = 10.0 * cable_loss(0.075, 0.010) / 0.340
    assert errors[[0, 2], 2] == pytest.approx([0.0, 0.0], abs=1e-3)
    assert errors[1, 2] == pytest.approx(-turn, abs=2e-3)


def test_ten_bumps_on_the_way_back_turn_the_robot_by_0_6_degrees_each(alone):
    """C 6.1, printed as -6 degrees; in reverse, a wheel on the right that falls behind turns to the left."""
    bumps = bumps_under("a.right", 10, 18.0, 36.0, lap=0)
    truth = Truth(alone, floor=Floor(0.0, bumps), sonar=Sonar(sigma=0.0))
    errors = return_errors(simulate(alone, truth, out_and_back(18.0, 1)), "a")
    assert np.degrees(errors[0, 2]) == pytest.approx(5.7, abs=0.1)


def test_a_slider_at_its_end_stop_ends_the_simulation(vehicle):
    truth = Truth(vehicle, floor=Floor(0.0, bumps_under("b.left", 400, 0.0, 18.0)), stroke=0.002)
    with pytest.raises(EndStopError) as caught:
        simulate(vehicle, truth, out_and_back(18.0, 1, link_length=1.0))
    assert abs(caught.value.length - 1.0) > 0.002
    assert caught.value.time > 0.0


def test_a_program_that_never_ends_is_given_up(alone, monkeypatch):
    monkeypatch.setattr("omnimate.vcan_sim.simulate.MAX_DURATION", 60.0)
    far = Program("free", (rest(1.0), Row(LINE, x=1e6, speed=0.5)), ())
    with pytest.raises(SimulationError, match="does not end"):
        simulate(alone, Truth(alone), far)
