"""The plant, stage by stage."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.effects.crossing import cable_loss
from omnimate.vcan_sim.biases import linkage_biases
from omnimate.vcan_sim.floor import SMOOTH, Bump, Floor
from omnimate.vcan_sim.plant import Plant
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.counters import counter_law, counters_of, take_readings
from omnimate.vehicle.linkage import linkage_of

DT = 0.015


def plant_of(vehicle, floor=SMOOTH, start=(0.0, 0.0, 0.0), **truth):
    return Plant(Truth(vehicle, floor=floor, **truth), vehicle, start)


def drive(plant, speeds, steps):
    for _ in range(steps):
        plant.step(speeds, DT)


def prompt(vehicle, **truth):
    """A plant whose wheels turn at once as fast as they are commanded."""
    return plant_of(vehicle, servo=1e9, **truth)


def test_equal_wheels_drive_straight_by_their_circumference(vehicle):
    plant = prompt(vehicle)
    drive(plant, (4.0,) * 4, 1000)
    assert plant.pose("a") == pytest.approx([4.0 * 1000 * DT * 0.075, 0.0, 0.0], abs=1e-9)
    assert plant.pose("b") == pytest.approx(plant.pose("a") - [1.0, 0.0, 0.0], abs=1e-9)


def test_unequal_speeds_drive_the_exact_circle_whatever_the_step(vehicle):
    for dt in (0.001, 0.015, 0.2):
        plant = prompt(vehicle)
        for _ in range(round(3.0 / dt)):
            plant.step((2.0, 3.0, 0.0, 0.0), dt)
        turn = 0.075 / 0.340 * 3.0
        radius = 2.5 / 1.0 * 0.340
        circle = [radius * math.sin(turn), radius * (1.0 - math.cos(turn)), turn]
        assert plant.pose("a") == pytest.approx(circle, abs=1e-9)


@settings(max_examples=30)
@given(
    sign=st.sampled_from([1, -1]),
    signed=st.booleans(),
    span=st.sampled_from([None, 4096, 65535, 100_000]),
    seed=st.integers(0, 1000),
    speed=st.floats(-6.0, 6.0),
)
def test_raw_wheel_counts_wrap_at_the_range_and_follow_the_angle_to_a_count(
    vehicle, sign, signed, span, seed, speed
):
    encoders = tuple(replace(encoder, sign=sign, signed=signed, range=span) for encoder in vehicle.encoders)
    robot = replace(vehicle, encoders=encoders)
    plant, counter = prompt(robot, seed=seed), counters_of([counter_law(encoders[0], robot)])
    span, low = encoders[0].wrap_range, -(encoders[0].wrap_range // 2) if signed else 0
    take_readings(counter, np.array(plant.raw_counts()[:1], np.int64))
    start = counter["count"][0]
    for step in range(1, 200):
        plant.step((speed, 0.0, 0.0, 0.0), DT)
        raw = plant.raw_counts()[0]
        assert low <= raw < low + span
        take_readings(counter, np.array([raw]))
        assert abs(counter["count"][0] - start - sign * 40000 / (2.0 * math.pi) * speed * DT * step) <= 1.0


def test_wheel_counters_begin_anywhere_and_by_the_seed(vehicle):
    assert plant_of(vehicle, seed=1).raw_counts() == plant_of(vehicle, seed=1).raw_counts()
    assert plant_of(vehicle, seed=1).raw_counts()[:4] != plant_of(vehicle, seed=2).raw_counts()[:4]


def test_joints_and_link_read_the_true_geometry_and_its_offsets_to_half_a_count(vehicle):
    bias = (0.02, -0.01)
    plant = prompt(vehicle, effects=linkage_biases(*bias, 0.003))
    drive(plant, (1.0, 2.5, 2.0, 1.2), 150)
    counts = dict(zip(vehicle.channels, plant.raw_counts(), strict=True))
    angles = linkage_of(plant.pose("a"), plant.pose("b"))
    for joint, true, offset in zip(("joint_a", "joint_b"), angles, bias, strict=False):
        encoder = vehicle.encoder(joint)
        read = (counts[joint] - encoder.zero) * encoder.scale
        assert abs(read - true - offset) <= 0.5 * abs(encoder.scale) + 1e-9
    link = vehicle.encoder("link")
    read = vehicle.linkage.length + (counts["link"] - link.zero) * link.scale
    assert abs(read - angles[2] - 0.003) <= 0.5 * abs(link.scale) + 1e-9


def test_joint_counts_go_on_over_whole_turns(vehicle):
    plant = prompt(vehicle)
    turns = 0.340 * math.pi / 0.075  # [rad] of each wheel for one turn of truck a
    drive(plant, (-2.0, 2.0, 0.0, 0.0), round(2.0 * turns / 2.0 / DT))
    joint = vehicle.channels.index("joint_a")
    assert plant.raw_counts()[joint] == pytest.approx(2 * 16384, abs=0.01 * 16384)


def test_a_single_truck_has_two_counters_and_no_linkage(alone):
    plant = prompt(alone)
    drive(plant, (2.0, 2.0), 100)
    assert len(plant.raw_counts()) == 2
    assert plant.pose("a")[0] == pytest.approx(2.0 * 100 * DT * 0.075)
    assert not plant.at_end_stop


def test_counts_stand_in_the_order_of_the_vehicle(vehicle):
    turned = replace(vehicle, encoders=vehicle.encoders[::-1])
    assert plant_of(turned).raw_counts() == plant_of(vehicle).raw_counts()[::-1]


def test_a_slider_pulled_too_far_is_marked(vehicle):
    plant = prompt(vehicle, stroke=0.1)
    drive(plant, (1.0, 1.0, 0.0, 0.0), 85)
    assert not plant.at_end_stop
    drive(plant, (1.0, 1.0, 0.0, 0.0), 10)
    assert plant.at_end_stop
    assert plant.link_length > 1.1
    drive(plant, (-1.0, -1.0, 0.0, 0.0), 50)
    assert plant.at_end_stop


@pytest.mark.parametrize("speeds", [(1.0, math.nan, 0.0, 0.0), (math.inf, 0.0, 0.0, 0.0), (1.0, 1.0)])
def test_speeds_that_are_no_numbers_or_too_few_are_refused(vehicle, speeds):
    with pytest.raises(ValueError, match="expected 4 finite numbers"):
        plant_of(vehicle).step(speeds, DT)


@pytest.mark.parametrize(("wheel", "side"), [("a.right", -1), ("a.left", 1), ("b.right", -1), ("b.left", 1)])
def test_a_bump_under_a_wheel_turns_its_truck_towards_the_wheel_by_the_loss_over_the_wheelbase(
    vehicle, wheel, side
):
    bump = Bump(0.010, "cable", wheel, after=0.5)
    plant = prompt(vehicle, floor=Floor(0.0, (bump,)))
    drive(plant, (4.0,) * 4, 105)
    assert plant.pose(wheel[0])[2] == 0.0
    drive(plant, (4.0,) * 4, 100)
    assert plant.pose(wheel[0])[2] == pytest.approx(side * cable_loss(0.075, 0.010) / 0.340)
    other = "b" if wheel.startswith("a") else "a"
    assert plant.pose(other)[2] == 0.0


def test_the_loss_is_spread_over_the_crossing(vehicle):
    plant = prompt(vehicle, floor=Floor(0.0, (Bump(wheel="a.right"),)))
    headings = []
    for _ in range(40):
        plant.step((4.0,) * 4, DT)
        headings.append(plant.pose("a")[2])
    steps = -np.diff([0.0, *headings])
    assert np.count_nonzero(steps > 1e-12) == math.ceil(Bump().crossing(0.075).rolled / (4.0 * 0.075 * DT))
    assert steps.max() == pytest.approx(steps[1])


def test_a_bump_crossed_in_reverse_costs_travel_the_other_way(vehicle):
    plant = prompt(vehicle, floor=Floor(0.0, (Bump(wheel="a.right", after=0.1),)))
    drive(plant, (-4.0,) * 4, 100)
    assert plant.pose("a")[2] == pytest.approx(cable_loss(0.075, 0.010) / 0.340)


def test_an_obstacle_on_the_floor_is_met_by_each_wheel_that_passes_there_every_time(vehicle):
    bump = Bump(x=1.0, y=-0.17, size=0.03)
    plant = prompt(vehicle, floor=Floor(0.0, (bump,)))
    turn = cable_loss(0.075, 0.010) / 0.340
    drive(plant, (4.0,) * 4, 270)
    assert plant.pose("a")[2] == pytest.approx(-turn)
    assert plant.pose("b")[2] == 0.0
    drive(plant, (4.0,) * 4, 200)
    assert plant.pose("b")[2] == pytest.approx(-turn)
    drive(plant, (-4.0,) * 4, 470)
    assert plant.pose("a")[2] == pytest.approx(0.0, abs=1e-12)


def test_fixes_scatter_about_the_true_pose_and_the_next_one_is_another(vehicle):
    plant = plant_of(vehicle, start=(0.1, 0.2, 0.05))
    fixes = np.array([plant.fix("a")[0] for _ in range(500)])
    sigma = plant.fix("a")[1]
    assert fixes.std(axis=0) == pytest.approx(sigma, rel=0.15)
    assert np.all(np.abs(fixes.mean(axis=0) - [0.1, 0.2, 0.05]) < 4.0 * sigma / math.sqrt(500))
    assert not np.array_equal(plant.fix("b")[0], plant.fix("b")[0])


def test_a_wider_wheelbase_and_a_larger_wheel_act_on_the_truth_not_on_the_counts(vehicle):
    truck = replace(vehicle.trucks["a"], wheelbase=0.400, wheel_diameter_left=0.160)
    true = Plant(Truth(vehicle.with_truck("a", truck), floor=SMOOTH, servo=1e9), vehicle)
    plain = prompt(vehicle)
    for plant in (true, plain):
        drive(plant, (3.0, 3.0, 3.0, 3.0), 100)
    assert true.raw_counts()[:4] == plain.raw_counts()[:4]
    assert true.pose("a")[2] == pytest.approx(-3.0 * 100 * DT * 0.005 / 0.400)
