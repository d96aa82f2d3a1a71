"""The simulator with effects in it."""

import math
from dataclasses import replace

import can
import numpy as np
import pytest

from omnimate.effects import EFFECTS, effect_named
from omnimate.motion.paths import out_and_back, squares
from omnimate.vcan_sim.errors import SimulationError
from omnimate.vcan_sim.floor import SMOOTH, Floor
from omnimate.vcan_sim.plant import Plant
from omnimate.vcan_sim.reference import reference_single, reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.simulated_vehicle import SimulatedVehicle
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.sonar import Sonar
from tests.effects.conftest import drive
from tests.vcan_sim.conftest import ListBus

DT = 0.015
ALONE = reference_single()
EXACT = {"floor": SMOOTH, "sonar": Sonar(sigma=0.0), "servo": 1e9}


@pytest.fixture(scope="module")
def vehicle():
    return reference_vehicle()


@pytest.fixture(scope="module")
def plain(vehicle):
    return simulate(vehicle, Truth(vehicle, seed=3), program(vehicle), start_time=50.0)


def program(vehicle):
    return squares(["ccw"], 0.5, link_length=vehicle.linkage.length)


def effect(name, component, **values):
    return effect_named(name)(component, **values)


def idle(kind):
    special = {"bump": {"times": (51.0,), "lost": (0.0,)}}
    values = {parameter.name: parameter.null for parameter in kind.parameters if parameter.null is not None}
    return kind(kind.components[0], **special.get(kind.name, values))


def weak(kind, component):
    """An effect of a plausible size that acts within a minute of driving."""
    special = {
        "bump": {"times": (52.0,), "lost": (2e-3,)},
        "radius_step": {"ratio": 1.01, "time": 52.0},
        "clock_drift": {"rate": 0.01},
        "law": {"formula": "0.02 * (1 + abs(speed))"},
    }
    values = {parameter.name: (parameter.null or 0.0) + parameter.scale for parameter in kind.parameters}
    if kind.name == "slip_patch":
        values["intervals"] = ()
    return kind(component, **special.get(kind.name, values))


@pytest.mark.parametrize("kind", EFFECTS, ids=lambda kind: kind.name)
def test_an_effect_at_null_leaves_every_count_as_it_was(vehicle, plain, kind):
    truth = Truth(vehicle, seed=3, effects=(idle(kind),))
    recording = simulate(vehicle, truth, program(vehicle), start_time=50.0)
    assert np.array_equal(recording.counts, plain.counts)
    assert recording.poses.pose == pytest.approx(plain.poses.pose, abs=1e-12)
    assert recording.run == plain.run


SEEN = [kind for kind in EFFECTS if kind.name not in {"castor_kick", "gear_backlash"}]  # no reversals here


@pytest.mark.parametrize("kind", SEEN, ids=lambda kind: kind.name)
def test_an_effect_is_seen_in_what_is_recorded(vehicle, plain, kind):
    for component in (kind.components[0], kind.components[-1]):
        truth = Truth(vehicle, seed=3, effects=(weak(kind, component),))
        recording = simulate(vehicle, truth, program(vehicle), start_time=50.0)
        length = min(len(recording), len(plain))
        if component == "poses" or kind.stage == "poses":
            assert np.array_equal(recording.counts[:length], plain.counts[:length])
            assert kind.stage != "poses" or not np.array_equal(recording.poses.pose, plain.poses.pose)
        else:
            assert not np.array_equal(recording.counts[:length], plain.counts[:length])


@pytest.mark.parametrize("name", ["castor_kick", "gear_backlash"])
def test_an_effect_of_reversals_is_seen_where_the_robot_comes_back(vehicle, name):
    course = out_and_back(0.5, 1, link_length=vehicle.linkage.length)
    kind = effect_named(name)
    changed = Truth(vehicle, seed=3, effects=(weak(kind, kind.components[0]),))
    first, second = (simulate(vehicle, truth, course) for truth in (Truth(vehicle, seed=3), changed))
    length = min(len(first), len(second))
    assert not np.array_equal(first.counts[:length], second.counts[:length])


EVERYTHING = (
    effect("wheel_diameter", "a.left", ratio=1.004),
    effect("wheel_eccentricity", "b.right", amplitude=4e-4, phase=1.2),
    effect("gear_backlash", "a.right", width=1e-3),
    effect("bump", "b.left", times=(0.6,), lost=(3e-3,)),
    effect("wheelbase", "a", ratio=0.99),
    effect("lateral_slip", "b", compliance=0.05),
    effect("joint_backlash", "joint_a", width=0.01),
    effect("link_scale", "link", ratio=1.1),
    effect("count_loss", "a.left", fraction=0.02, above=0.1),
    effect("latency", "joint_b", delay=0.05),
    effect("clock_drift", "b.left", rate=0.01),
)


def speeds(steps):
    time = DT * np.arange(steps)[:, None]
    return 4.0 * np.sin(1.7 * time + [0.0, 0.1, 0.2, 0.05])


def test_steps_of_the_plant_equal_one_block_of_the_whole_drive(vehicle):
    """What a diagnosis replays from the wheels' motion is what the simulator did."""
    reading = (
        effect("joint_bias", "joint_a", bias=0.01),
        effect("joint_eccentricity", "joint_b", amplitude=0.01, phase=0.3),
        effect("latency", "joint_b", delay=0.04),
        effect("link_scale", "link", ratio=1.3),
    )
    nominal = Plant(Truth(vehicle, **EXACT), vehicle)
    altered = Plant(Truth(vehicle, effects=reading, **EXACT), vehicle)
    true, counted = [], []
    for command in speeds(200):
        for plant in (nominal, altered):
            plant.step(command, DT)
        true.append([*nominal.state["joint"][0], nominal.link_length])
        counted.append(altered.raw_counts()[4:])
    blocks = replace(drive(200), reading=np.array(true))
    for acting in reading:
        blocks, _ = acting.act(blocks)
    zero = np.array([0.0, 0.0, vehicle.linkage.length])
    scale = np.array([vehicle.encoder(name).scale for name in ("joint_a", "joint_b", "link")])
    start = np.array([vehicle.encoder(name).zero for name in ("joint_a", "joint_b", "link")])
    shown = zero + scale * (np.array(counted) - start)
    assert np.abs(shown - blocks.reading).max(axis=0) == pytest.approx(0.5 * np.abs(scale), rel=0.1)


def test_a_live_vehicle_counts_as_a_plant_and_as_simulate_does(vehicle):
    truth = Truth(vehicle, seed=7, effects=EVERYTHING)
    recording = simulate(vehicle, truth, program(vehicle))
    plant, live, heard = Plant(truth, vehicle), Plant(truth, vehicle), []
    commands = iter(recording.commands)
    simulated = SimulatedVehicle(vehicle, live, ListBus(), wheel_speeds=lambda: tuple(next(commands)))
    for command in recording.commands[:400]:
        assert plant.raw_counts() == live.raw_counts()
        heard.append(live.raw_counts())
        plant.step(command, vehicle.bus.sync_period)
        simulated.receive(can.Message(arbitration_id=0x80, is_extended_id=False))
    spans = np.array([encoder.wrap_range for encoder in vehicle.encoders])
    assert not ((np.array(heard) - recording.counts[:400]) % spans).any()


def way(vehicle, *effects, steps=200, command=(4.0, 4.0, 4.0, 4.0), **truth):
    plant = Plant(Truth(vehicle, effects=effects, **(EXACT | truth)), vehicle)
    for _ in range(steps):
        plant.step(command[: len(vehicle.wheels)], DT)
    return plant


def test_effects_of_a_wheel_move_the_truck_and_leave_its_counts(vehicle):
    plain, larger = way(ALONE), way(ALONE, effect("wheel_diameter", "a.left", ratio=1.01))
    radius = 0.5 * ALONE.wheel_diameter("a.left")
    turn = -0.01 * 4.0 * 200 * DT * radius / ALONE.trucks["a"].wheelbase
    assert larger.pose("a")[2] == pytest.approx(turn)
    assert larger.raw_counts() == plain.raw_counts()


def test_a_bump_on_a_rough_floor_turns_the_truck_by_lost_over_wheelbase_beyond_its_roughness():
    bump = effect("bump", "a.right", times=(0.5,), lost=(4e-3,))
    for floor in (SMOOTH, Floor(1e-3)):
        plain, bumped = way(ALONE, floor=floor), way(ALONE, bump, floor=floor)
        turn = bumped.pose("a")[2] - plain.pose("a")[2]
        assert turn == pytest.approx(
            -4e-3 / ALONE.trucks["a"].wheelbase, rel=0.1 if floor.roughness else 1e-9
        )


def test_events_are_on_the_clock_that_starts_at_start_time():
    step = effect("radius_step", "a.left", ratio=1.1, time=1001.5)
    truth = Truth(ALONE, effects=(step,), **EXACT)
    headings = []
    for start in (1000.0, 1001.5, 2000.0, 0.0):
        plant = Plant(truth, ALONE, start_time=start)
        for _ in range(200):
            plant.step((4.0, 4.0), DT)
        headings.append(plant.pose("a")[2])
    assert headings == pytest.approx(headings[1] * np.array([0.5, 1.0, 1.0, 0.0]), abs=1e-9)
    assert headings[1] < -0.1


def test_the_clock_catches_up_where_syncs_pause():
    now = [10.0]
    truth = Truth(ALONE, effects=(effect("radius_step", "a.left", ratio=1.1, time=100.0),), **EXACT)
    plant = Plant(truth, ALONE, start_time=10.0, clock=lambda: now[0])
    plant.step((4.0, 4.0), DT)
    assert plant.pose("a")[2] == 0.0
    now[0] = 200.0
    plant.step((4.0, 4.0), DT)
    assert plant.pose("a")[2] < 0.0


def test_count_loss_loses_counts_and_no_way(vehicle):
    plain, losing = way(ALONE), way(ALONE, effect("count_loss", "a.left", fraction=0.25, above=0.1))
    before = Plant(Truth(ALONE), ALONE).raw_counts()
    counted = [plant.raw_counts()[0] - before[0] for plant in (plain, losing)]
    assert counted[1] == pytest.approx(0.75 * counted[0], abs=1.0)
    assert losing.raw_counts()[1] == plain.raw_counts()[1]
    assert losing.pose("a") == pytest.approx(plain.pose("a"), abs=1e-15)


def test_what_is_read_before_the_first_step_has_the_effects_too(vehicle):
    bias = effect("joint_bias", "joint_a", bias=0.05)
    plant = Plant(Truth(vehicle, effects=(bias,)), vehicle)
    encoder = vehicle.encoder("joint_a")
    assert (plant.raw_counts()[4] - encoder.zero) * encoder.scale == pytest.approx(0.05, abs=encoder.scale)


def test_a_slope_takes_the_trucks_downhill_whatever_their_heading():
    slope = effect("floor_slope", "a", rate=0.01, direction=0.5 * math.pi)
    plain, tilted = (way(ALONE, *effects, command=(3.0, 5.0), steps=400) for effects in ((), (slope,)))
    travelled = 4.0 * 400 * DT * 0.5 * ALONE.wheel_diameter("a.left")
    assert tilted.pose("a") - plain.pose("a") == pytest.approx([0.0, 0.01 * travelled, 0.0], abs=1e-4)


@pytest.mark.parametrize(
    ("late", "age"),
    [
        (("latency", {"delay": 0.3}), 0.3),
        (("clock_drift", {"rate": 0.1}), 0.3),
        (("clock_drift", {"rate": -0.1}), -0.3),
    ],
    ids=["latency", "clock drift", "clock that is slow"],
)
def test_fixes_report_the_pose_of_some_time_ago(late, age):
    name, values = late
    plant = way(ALONE, effect(name, "poses", **values))
    speed = 4.0 * 0.5 * ALONE.wheel_diameter("a.left")
    assert plant.pose("a")[0] - plant.fix("a")[0][0] == pytest.approx(age * speed, abs=1e-9)


def test_an_effect_on_what_the_robot_has_not_is_refused():
    for name, component in (("wheel_diameter", "b.left"), ("joint_bias", "joint_a"), ("wheelbase", "b")):
        with pytest.raises(SimulationError, match=f"{name}: .* has no {component}; expected one of a.left"):
            Truth(ALONE, effects=(effect_named(name)(component),))
    assert replace(Truth(ALONE), effects=(effect("latency", "poses", delay=0.1),)).effects
