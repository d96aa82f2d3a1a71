"""Laws: what formulas and curves do, and that they do the same as the effects that have a name."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.effects import effect_named
from omnimate.effects.errors import EffectError, EffectsFileError
from omnimate.effects.file import format_effects, parse_effects
from omnimate.effects.law import Law, law_quantities
from omnimate.effects.stages import replay
from omnimate.effects.variables import (
    RECENT_SPEED_TIME,
    ROLLED_DISTANCE,
    TURNED_ANGLE,
    VARIABLES,
    Motion,
    available_variables,
)
from omnimate.vcan_sim.floor import SMOOTH
from omnimate.vcan_sim.plant import Plant
from omnimate.vcan_sim.reference import reference_single, reference_vehicle
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.linkage import linkage_of
from omnimate.vehicle.sonar import Sonar

PERIOD, START = 0.015, 1000.0
TARGETS = [(component, acts_on) for component in Law.components for acts_on in law_quantities(component)]


def law(component, formula="0", acts_on="", **curve):
    return Law(component, acts_on, formula, **curve)


@st.composite
def laws(draw):
    """Laws of every quantity, over every variable that a component has."""
    component, acts_on = draw(st.sampled_from(TARGETS))
    names = st.sampled_from(sorted(available_variables(component)))
    formula = f"0.01 * {draw(names)} - 0.02 * sin({draw(names)}) / (1 + abs({draw(names)}))"
    curve = {"over": draw(names), "knots": (-1.0, 0.0, 2.0), "ordinates": (0.1, -0.1, 0.2)}
    return law(component, formula, acts_on, **curve, period=draw(st.sampled_from([0.0, math.tau])))


@pytest.mark.slow
@settings(max_examples=60)
@given(acting=laws(), cuts=st.lists(st.integers(0, 400), max_size=5))
def test_a_drive_in_pieces_gives_the_same_as_the_whole(block, acted, acting, cuts):
    whole, parts = acted(acting, block), acted(acting, block, cuts)
    for name, signal in whole.items():
        assert parts[name] == pytest.approx(signal, abs=1e-11)
    assert parse_effects(format_effects([acting])) == (acting,)


@pytest.mark.parametrize(
    ("laws_", "named"),
    [
        ([("a.left", "0.1 * abs(speed)", "travel")], ("radius_vs_speed", "a.left", {"slope": 0.1})),
        ([("b.right", "0.02", "")], ("wheel_diameter", "b.right", {"ratio": 1.02})),
        ([("a", "1 / 0.98 - 1", "turn")], ("wheelbase", "a", {"ratio": 0.98})),
        ([("joint_b", "0.01 * cos(joint_b + 0.3)", "")],
            ("joint_eccentricity", "joint_b", {"amplitude": 0.01, "phase": 0.3})),
        ([("link", "0.3 * (link - 1)", "reading")], ("link_scale", "link", {"ratio": 1.3})),
        ([("b", "0.01 * cos(0.7 - heading)", "forward"), ("b", "0.01 * sin(0.7 - heading)", "creep")],
            ("floor_slope", "b", {"rate": 0.01, "direction": 0.7})),
    ],
)  # fmt: skip
def test_a_law_that_says_what_a_named_effect_does_does_the_same(block, laws_, named):
    name, component, values = named
    ours = replay(block, [law(*one) for one in laws_])
    theirs = replay(block, [effect_named(name)(component, **values)])
    for signal in ("travel", "twist", "reading"):
        # two laws in turn: the second one sees the way forward that the first one has changed
        assert getattr(ours, signal) == pytest.approx(
            getattr(theirs, signal), abs=2e-6 if name == "floor_slope" else 1e-12
        )


def test_yaw_goes_with_the_way_in_either_direction(block, acted):
    after = acted(law("a", "0.5", "yaw"), block)
    assert after["twist"][:, 0, 2] == pytest.approx(block.twist[:, 0, 2] + 0.5 * np.abs(block.twist[:, 0, 0]))


@pytest.mark.parametrize("acts_on", ["yaw", "turn"])
def test_the_simulator_does_what_a_replay_does(acts_on):
    """A truck in an arc, on which a law acts for some hundred steps."""
    alone = reference_single()
    acting = law("a", "0.02 * way + 0.1 * sin(heading) + 0.05 * x", acts_on)
    plants = [
        Plant(Truth(alone, effects=effects, floor=SMOOTH, sonar=Sonar(sigma=0.0), servo=1e9), alone)
        for effects in ((), (acting,))
    ]
    headings = []
    for _ in range(300):
        for plant in plants:
            plant.step((4.0, 6.0), PERIOD)
        headings.append([plant.pose("a")[2] for plant in plants])
    plain, bent = np.array(headings).T
    radius = 0.5 * alone.wheel_diameter("a.left")
    forward, yaw = 5.0 * radius * PERIOD, 2.0 * radius * PERIOD / alone.trucks["a"].wheelbase
    assert plain[-1] == pytest.approx(300 * yaw)
    heading, x = 0.0, 0.0
    for step in range(1, 301):
        middle = heading + 0.5 * yaw
        f = 0.02 * step * forward + 0.1 * math.sin(middle) + 0.05 * (x + 0.5 * forward * math.cos(middle))
        more = f * (forward if acts_on == "yaw" else yaw)
        x += forward * math.cos(heading + 0.5 * (yaw + more))
        heading += yaw + more
    assert bent[-1] == pytest.approx(heading, abs=2e-5)
    assert abs(bent[-1] - plain[-1]) > 0.05


def test_variables_are_what_the_block_says_of_the_component(block):
    wheel, truck = Motion(block, "a.right"), Motion(block, "b")
    of_wheel, of_truck = wheel.values(available_variables("a.right")), truck.values(available_variables("b"))
    assert of_wheel["speed"] == pytest.approx(block.speed[:, 1])
    assert of_truck["acceleration"] == pytest.approx(block.acceleration[:, 2:].mean(axis=1))
    assert of_wheel["way"][-1] == pytest.approx(np.abs(block.travel[:, 1]).sum(), rel=1e-6)
    assert of_wheel["turn_rate"] == pytest.approx((block.speed[:, 1] - block.speed[:, 0]) / 0.34)
    assert of_truck["load"] == pytest.approx(of_truck["speed"] * of_truck["turn_rate"])
    assert of_wheel["wheel_angle"] == pytest.approx(of_truck["wheel_angle_a_right"])
    assert of_truck["time"] == pytest.approx(block.time - START)
    assert np.array_equal(of_truck["heading"], block.heading[:, 1])
    assert np.array_equal(of_truck["y"], block.place[:, 1, 1])
    assert np.array_equal(of_wheel["link"], block.reading[:, 2])
    assert set(of_wheel) == set(VARIABLES)


def test_a_truck_turns_on_until_it_reverses_and_again_after_a_turn_longer_than_its_memory(block):
    """It is the state of Dahl's friction, in units of the friction."""
    rate = np.repeat([0.5, 0.0, -0.5], [133, 133, 134])
    speed = 0.17 * np.stack([-rate, rate, -rate, rate], axis=1)
    turning = Motion(replace(block, speed=speed), "b").turning_on
    turned = 0.5 * 133 * PERIOD
    assert turning[132] == pytest.approx(1.0 - math.exp(-turned / TURNED_ANGLE))
    assert not turning[133:266].any()
    assert turning[266] == pytest.approx(-turning[132], abs=0.1)
    assert (np.diff(turning[266:]) > 0.0).all()


def test_what_rolls_on_is_known_for_each_wheel_and_changes_its_sign_where_it_reverses(block):
    speed = 0.2 * np.sign(block.speed)
    way, direction = 0.2 * PERIOD, np.sign(block.speed[:, 1])
    rolling = Motion(replace(block, speed=speed), "a.right").rolling_on
    back = np.flatnonzero(direction[1:] != direction[:-1])[0] + 1
    assert rolling[back - 1] == pytest.approx(1.0 - math.exp(-back * way / ROLLED_DISTANCE))
    assert rolling[back] == pytest.approx(1.0 - math.exp(-way / ROLLED_DISTANCE) * (1.0 + rolling[back - 1]))
    assert rolling[back + 20] > 0.99


def test_a_tyres_recent_speed_grows_to_its_speed_and_falls_when_it_stands(block):
    steps = len(block)
    speed = np.where(np.arange(steps) < 200, -0.3, 0.0)[:, None] * np.ones(4)
    period = np.full(steps, 0.5)
    recent = Motion(replace(block, speed=speed, period=period), "a.left").recent_speed
    assert recent[199] == pytest.approx(0.3 * (1.0 - math.exp(-100.0 / RECENT_SPEED_TIME)))
    assert recent[-1] == pytest.approx(recent[199] * math.exp(-100.0 / RECENT_SPEED_TIME))


def test_rates_of_the_linkage_are_how_its_readings_change_as_the_trucks_move(block):
    own = Motion(block, "link").values(["joint_a_rate", "joint_b_rate", "link_rate"])
    joint_a, joint_b, length = block.reading.T
    zeros, moment = np.zeros(len(block)), 1e-6
    speed = 0.5 * (block.speed[:, 0::2] + block.speed[:, 1::2])
    turn = (block.speed[:, 1::2] - block.speed[:, 0::2]) / block.wheelbase
    before = [np.stack(pose, axis=1) for pose in ((zeros, zeros, joint_a), (-length, zeros, joint_b))]
    after = [
        pose
        + moment
        * np.stack(
            [speed[:, truck] * np.cos(pose[:, 2]), speed[:, truck] * np.sin(pose[:, 2]), turn[:, truck]],
            axis=1,
        )
        for truck, pose in enumerate(before)
    ]
    for name, then, now in zip(own, linkage_of(*before), linkage_of(*after), strict=True):
        assert own[name] == pytest.approx((now - then) / moment, abs=1e-5)


def test_a_curve_is_straight_between_knots_constant_beyond_them_and_repeats_with_its_period():
    values = {"speed": np.array([-9.0, 0.25, 9.0])}
    curve = {"over": "speed", "knots": (0.0, 1.0), "ordinates": (0.1, 0.3)}
    assert law("a", **curve).value(values) == pytest.approx([0.1, 0.15, 0.3])
    repeated = law("a", **curve, period=2.0).value(values)
    assert repeated == pytest.approx([0.3, 0.15, 0.3])
    assert law("a", "1", **curve).value(values) == pytest.approx([1.1, 1.15, 1.3])


@pytest.mark.parametrize(
    ("component", "fields", "problem"),
    [
        ("a.left", {"acts_on": "yaw"}, "acts_on = 'yaw'; expected one of travel"),
        ("a", {"acts_on": "travel"}, "expected one of yaw, turn, creep, forward"),
        ("a", {"formula": "wheel_angle"}, "variable 'wheel_angle'; expected one of speed"),
        ("a", {"formula": "velocity"}, "variable 'velocity'; expected one of speed"),
        ("a", {"formula": "2 *"}, "column 4: 'the end'; expected a number"),
        ("a", {"over": "speed"}, "expected both or neither"),
        ("a", {"over": "speed", "knots": (0.0, 1.0), "ordinates": (0.0,)}, "2 knots, 1 ordinates"),
        ("a", {"over": "speed", "knots": (1.0, 1.0), "ordinates": (0.0, 0.0)}, "out of order"),
        ("a", {"over": "x", "knots": (0.0, 2.0), "ordinates": (0.0, 0.0), "period": 2.0}, "less than 2"),
    ],
)
def test_a_law_that_cannot_act_is_refused_with_what_was_expected(component, fields, problem):
    with pytest.raises(EffectError, match=f"(?s).*{problem}".replace("*'", "\\*'")):
        Law(component, **fields)


def test_a_bad_formula_in_a_file_is_named_with_its_place():
    text = '[[effect]]\nname = "law"\ncomponent = "a"\nformula = "speed +"\n'
    with pytest.raises(
        EffectsFileError, match=r"effect 1: formula 'speed \+', column 8: 'the end'; expected"
    ):
        parse_effects(text)


def test_uncertainties_of_terms_and_of_ordinates_do_no_harm_in_a_file():
    acting = law("a", "0.1 * speed", over="x", knots=(0.0, 1.0), ordinates=(0.0, 0.1))
    text = format_effects([acting], [{"speed": 1e-3, "ordinates": [0.01, 0.02]}])
    assert "speed = 0.001" in text
    assert parse_effects(text) == (acting,)


def test_a_law_without_a_value_at_some_step_stops_with_the_time(block):
    with pytest.raises(EffectError, match=r"no finite number 3 s after the start"):
        law("a", "log(3 - time)").act(block)
    with pytest.raises(EffectError, match=r"no finite number 0\.015 s"):
        law("a", "1 / 0").act(block)


def test_variables_of_a_truck_that_is_not_there_are_refused_when_the_robot_moves():
    alone = reference_single()
    plant = Plant(Truth(alone, effects=(law("a", "joint_a"),)), alone)
    with pytest.raises(EffectError, match="variable 'joint_a' of a; expected one of speed"):
        plant.step((1.0, 1.0), PERIOD)


def test_a_law_of_a_reading_is_in_what_is_read_before_the_first_step():
    vehicle = reference_vehicle()
    plant = Plant(Truth(vehicle, effects=(law("joint_a", "0.05"),)), vehicle)
    encoder = vehicle.encoder("joint_a")
    assert (plant.raw_counts()[4] - encoder.zero) * encoder.scale == pytest.approx(0.05, abs=encoder.scale)


@pytest.mark.parametrize(
    ("effect", "sentence"),
    [
        (
            law("joint_b", "0.004 * speed"),
            "the encoder of joint b reads f rad more, f = 0.004 * speed in SI units",
        ),
        (
            law("b.left", over="speed", knots=(0.1, 0.5), ordinates=(-0.01, 0.02)),
            (
                "the left wheel of truck b travels (1 + f) of what it would, "
                "f = a curve over speed (-0.01 at 0.1, 0.02 at 0.5) in SI units"
            ),
        ),
    ],
)
def test_a_law_is_described_by_its_component_formula_and_curve(effect, sentence):
    assert effect.describe(reference_vehicle()) == sentence


@pytest.mark.parametrize("component", Law.components)
def test_each_quantity_that_a_law_acts_on_has_a_sentence_of_its_own(component):
    quantities = law_quantities(component)
    sentences = {law(component, "0.1", acts_on).describe(reference_vehicle()) for acts_on in quantities}
    assert len(sentences) == len(quantities)
