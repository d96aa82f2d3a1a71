"""Of every effect the sentence of its contract, measured."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.effects import effect_named
from omnimate.effects.crossing import crossing_with_loss
from omnimate.effects.errors import EffectError

PERIOD, START = 0.015, 1000.0


def effect(name, component, **values):
    return effect_named(name)(component, **values)


@pytest.fixture
def forward(block):
    """All wheels at 0.3 m/s, ever forward, the trucks straight."""
    turned = np.full(block.turned.shape, 0.3 * PERIOD / 0.075)
    return replace(
        block,
        turned=turned,
        angle=5.0 + np.cumsum(turned, axis=0),
        travel=0.075 * turned,
        speed=np.full(turned.shape, 0.3),
        acceleration=np.zeros(turned.shape),
    ).rolled()


def test_wheel_diameter_rolls_ratio_times_the_way(block, acted):
    after = acted(effect("wheel_diameter", "a.right", ratio=1.02), block)
    assert after["travel"][:, 1] == pytest.approx(1.02 * block.travel[:, 1])
    assert np.array_equal(after["travel"][:, [0, 2, 3]], block.travel[:, [0, 2, 3]])


def test_wheel_eccentricity_has_radius_r_plus_amplitude_cos_of_angle_and_phase(block, acted):
    after = acted(effect("wheel_eccentricity", "b.left", amplitude=1e-3, phase=0.4), block)
    middle = block.angle[:, 2] - 0.5 * block.turned[:, 2]
    radius = 0.075 + 1e-3 * np.cos(middle + 0.4)
    assert after["travel"][:, 2] == pytest.approx(radius * block.turned[:, 2], abs=3e-8)


def test_radius_vs_speed_grows_with_speed_in_either_direction(block, acted):
    after = acted(effect("radius_vs_speed", "a.left", slope=0.1), block)
    factor = 1.0 + 0.1 * np.abs(block.speed[:, 0])
    assert after["travel"][:, 0] == pytest.approx(factor * block.travel[:, 0])


def test_radius_step_scales_from_its_time_on(block, acted):
    after = acted(effect("radius_step", "a.left", ratio=0.98, time=START + 3.0), block)
    later = block.time > START + 3.0
    assert np.array_equal(after["travel"][~later], block.travel[~later])
    assert after["travel"][later, 0] == pytest.approx(0.98 * block.travel[later, 0])


def test_a_bump_takes_exactly_lost_and_only_while_it_is_crossed(forward, acted):
    after = acted(effect("bump", "a.left", times=(START + 1.0, START + 3.0), lost=(2e-3, 5e-3)), forward)
    missing = forward.travel[:, 0] - after["travel"][:, 0]
    assert missing.sum() == pytest.approx(7e-3, abs=1e-12)
    first = (forward.time > START + 1.0) & (
        forward.time < START + 1.0 + crossing_with_loss(0.075, 2e-3).rolled / 0.3 + PERIOD
    )
    assert missing[first].sum() == pytest.approx(2e-3, abs=1e-12)
    assert not missing[forward.time <= START + 1.0].any()


def test_a_bump_in_reverse_takes_the_way_back_too(forward, acted):
    back = replace(forward, turned=-forward.turned, travel=-forward.travel, speed=-forward.speed)
    after = acted(effect("bump", "a.left", times=(START + 1.0,), lost=(2e-3,)), back)
    assert after["travel"][:, 0].sum() == pytest.approx(back.travel[:, 0].sum() + 2e-3, abs=1e-12)


def test_a_bump_before_a_motion_of_which_nothing_is_remembered_is_over(forward, acted):
    early, now = START - 5.0, START + 1.0
    both = acted(effect("bump", "a.left", times=(early, now), lost=(5e-3, 2e-3)), forward)
    alone = acted(effect("bump", "a.left", times=(now,), lost=(2e-3,)), forward)
    assert np.array_equal(both["travel"], alone["travel"])


def test_as_many_losses_as_times_are_asked_for():
    with pytest.raises(EffectError, match="expected equal"):
        effect("bump", "a.left", times=(1.0, 2.0), lost=(1e-3,))


def test_slip_patch_takes_the_fraction_on_its_stretches_and_always_where_none_is_given(block, acted):
    stretch = (START + 1.0, START + 2.0)
    after = acted(effect("slip_patch", "b.right", fraction=0.2, intervals=(stretch,)), block)
    inside = (block.time > stretch[0]) & (block.time <= stretch[1])
    assert after["travel"][:, 3] == pytest.approx(np.where(inside, 0.8, 1.0) * block.travel[:, 3])
    always = acted(effect("slip_patch", "b.right", fraction=0.2), block)
    assert always["travel"][:, 3] == pytest.approx(0.8 * block.travel[:, 3])


@pytest.mark.parametrize(("component", "wheels"), [("a.right", [1]), ("a", [0, 1]), ("b", [2, 3])])
def test_traction_slip_travels_v_minus_compliance_a_v(block, acted, component, wheels):
    after = acted(effect("traction_slip", component, compliance=0.1), block)
    slip = 0.1 * block.acceleration * np.abs(block.speed) * PERIOD
    expected = block.travel.copy()
    expected[:, wheels] -= slip[:, wheels]
    assert after["travel"] == pytest.approx(expected)


def test_gear_backlash_stands_still_through_the_play_at_each_reversal(block, acted):
    after = acted(effect("gear_backlash", "a.left", width=0.004), block)
    turns = np.flatnonzero(np.diff(np.sign(block.travel[:, 0]))) + 1
    missing = block.travel[:, 0] - after["travel"][:, 0]
    assert len(turns) == 2
    edges = [0, *turns, len(block)]
    for number, (start, end) in enumerate(itertools.pairwise(edges)):
        expected = [0.0, -0.004, 0.004][number]
        assert missing[start:end].sum() == pytest.approx(expected, abs=1e-12)
    assert np.all(after["travel"][turns, 0] == pytest.approx(0.0, abs=1e-12))


def test_gear_backlash_without_reversals_shows_nothing(forward, acted):
    after = acted(effect("gear_backlash", "a.left", width=0.004), forward)
    assert after["travel"] == pytest.approx(forward.travel, abs=1e-13)


def test_gear_harmonic_travels_s_plus_amplitude_cos_of_order_angle_and_phase(block, acted):
    after = acted(effect("gear_harmonic", "a.left", amplitude=1e-3, order=7.0, phase=0.3), block)
    way = np.cumsum(after["travel"][:, 0] - block.travel[:, 0])
    wave = 1e-3 * np.cos(7.0 * block.angle[:, 0] + 0.3)
    assert way == pytest.approx(wave - 1e-3 * math.cos(7.0 * 5.0 + 0.3), abs=1e-12)


def test_count_loss_keeps_a_fraction_from_arriving_above_a_speed_and_recover_gives_it_back(block, acted):
    loss = effect("count_loss", "a.left", fraction=0.25, above=0.2)
    after = acted(loss, block)
    fast = np.abs(block.speed[:, 0]) > 0.2
    assert after["turned"][:, 0] == pytest.approx(np.where(fast, 0.75, 1.0) * block.turned[:, 0])
    assert after["angle"][:, 0] == pytest.approx(5.0 + np.cumsum(after["turned"][:, 0]))
    slower = np.where(fast, 0.75, 1.0)[:, None]
    counted = replace(block, travel=0.075 * after["turned"], speed=slower * block.speed)
    back = loss.recover(counted)
    certain = ~((np.abs(block.speed[:, 0]) > 0.15) & ~fast)  # what is counted so fast may be either
    assert back.travel[certain, 0] == pytest.approx(block.travel[certain, 0])


def test_wheelbase_and_turn_scrub_divide_the_yaw(block, acted):
    twist = block.twist[:, 0]
    wider = acted(effect("wheelbase", "a", ratio=1.1), block)["twist"]
    assert wider[:, 0, 2] == pytest.approx(twist[:, 2] / 1.1)
    across = 0.5 * 0.340 * twist[:, 2]
    curvature = np.abs(twist[:, 2]) / np.hypot(twist[:, 0], across)
    scrubbed = acted(effect("turn_scrub", "a", slope=0.02), block)["twist"]
    assert scrubbed[:, 0, 2] == pytest.approx(twist[:, 2] / (1.0 + 0.02 * curvature))
    assert np.array_equal(scrubbed[:, 1], block.twist[:, 1])


def test_turn_scrub_on_the_spot_is_finite(block, acted):
    spin = np.zeros_like(block.twist)
    spin[:, :, 2] = 0.01
    scrubbed = acted(effect("turn_scrub", "a", slope=0.01), replace(block, twist=spin))["twist"]
    assert scrubbed[:, 0, 2] == pytest.approx(0.01 / (1.0 + 0.01 * 2.0 / 0.340))


def test_wheel_misalignment_goes_along_the_axles_normal(block, acted):
    after = acted(effect("wheel_misalignment", "b", angle=0.1), block)["twist"][:, 1]
    assert after[:, 0] == pytest.approx(math.cos(0.1) * block.twist[:, 1, 0])
    assert after[:, 1] == pytest.approx(math.sin(0.1) * block.twist[:, 1, 0])


def test_lateral_slip_creeps_outwards_by_compliance_times_centripetal_acceleration(block, acted):
    after = acted(effect("lateral_slip", "a", compliance=0.05), block)["twist"][:, 0]
    speed, rate = block.twist[:, 0, 0] / PERIOD, block.twist[:, 0, 2] / PERIOD
    assert after[:, 1] / PERIOD == pytest.approx(-0.05 * speed * rate)


def test_floor_slope_creeps_towards_its_direction_of_the_world_whatever_the_heading(block, acted):
    after = acted(effect("floor_slope", "a", rate=0.02, direction=0.7), block)["twist"][:, 0]
    creep, heading = after - block.twist[:, 0], block.heading[:, 0]
    east = np.cos(heading) * creep[:, 0] - np.sin(heading) * creep[:, 1]
    north = np.sin(heading) * creep[:, 0] + np.cos(heading) * creep[:, 1]
    way = np.abs(block.twist[:, 0, 0])
    assert east == pytest.approx(0.02 * way * math.cos(0.7))
    assert north == pytest.approx(0.02 * way * math.sin(0.7))


def test_on_a_film_floor_slope_creeps_as_fast_where_the_truck_stands(block, acted):
    still = replace(block, twist=np.zeros_like(block.twist))
    after = acted(effect("floor_slope", "a", rate=0.02, direction=0.7, pace=0.3), still)["twist"][:, 0]
    assert np.hypot(after[:, 0], after[:, 1]) == pytest.approx(0.02 * 0.3 * still.period)


def test_castor_kick_does_not_take_coarse_counts_at_standstill_for_reversals(block, acted):
    twist = np.zeros_like(block.twist)
    twist[:100, 0, 0], twist[300:, 0, 0] = 0.003, -0.003
    twist[100:300, 0, 0] = 4e-4 * (-1.0) ** np.arange(200)
    after = acted(effect("castor_kick", "a", yaw=0.01), replace(block, twist=twist))["twist"]
    assert np.flatnonzero(after[:, 0, 2]).tolist() == [300]


def test_castor_kick_yaws_once_at_each_reversal_of_travel_and_not_for_noise_at_standstill(block, acted):
    way = PERIOD * np.repeat([0.2, 0.0, -0.2, 0.0, -0.2, 0.2], [50, 50, 100, 50, 50, 100])
    way[50:100] += 1e-5 * (-1.0) ** np.arange(50)
    twist = np.zeros_like(block.twist)
    twist[:, 0, 0] = way
    after = acted(effect("castor_kick", "a", yaw=0.01), replace(block, twist=twist))["twist"]
    assert np.flatnonzero(after[:, 0, 2]).tolist() == [100, 300]
    assert after[[100, 300], 0, 2].tolist() == [0.01, 0.01]


def test_biases_and_eccentricities_add_to_the_readings(block, acted):
    angle = block.reading[:, 1]
    biased = acted(effect("joint_bias", "joint_b", bias=0.02), block)["reading"]
    assert biased[:, 1] == pytest.approx(angle + 0.02)
    wave = acted(effect("joint_eccentricity", "joint_b", amplitude=0.01, phase=0.5), block)["reading"]
    assert wave[:, 1] == pytest.approx(angle + 0.01 * np.cos(angle + 0.5))
    longer = acted(effect("link_bias", "link", bias=0.004), block)["reading"]
    assert longer[:, 2] == pytest.approx(block.reading[:, 2] + 0.004)
    swung = acted(effect("link_eccentricity", "link", amplitude=0.003, phase=0.5), block)["reading"]
    assert swung[:, 2] == pytest.approx(block.reading[:, 2] + 0.003 * np.cos(block.reading[:, 0] + 0.5))


def test_link_scale_acts_on_the_difference_from_rest(block, acted):
    after = acted(effect("link_scale", "link", ratio=1.5), block)["reading"]
    assert after[:, 2] - 1.0 == pytest.approx(1.5 * (block.reading[:, 2] - 1.0))


def test_joint_backlash_lags_by_half_its_width_to_either_side(block, acted):
    after = acted(effect("joint_backlash", "joint_a", width=0.04), block)["reading"]
    lag = block.reading[:, 0] - after[:, 0]
    assert lag.max() == pytest.approx(0.02)
    assert lag.min() == pytest.approx(-0.02)
    between = np.abs(lag) < 0.02 - 1e-12
    assert not np.diff(after[:, 0])[between[1:]].any()


@pytest.mark.parametrize(
    ("name", "values", "age"),
    [("latency", {"delay": 0.1}, 0.1), ("clock_drift", {"rate": 0.02}, None)],
)
def test_aged_samples_show_what_was_there_before(block, acted, name, values, age):
    ages = np.full(len(block), age) if age is not None else 0.02 * (block.time - START)
    then = block.time - ages
    reading = acted(effect(name, "link", **values), block)["reading"][:, 2]
    held = np.interp(then, block.time, block.reading[:, 2])
    assert reading == pytest.approx(held, abs=1e-12)
    aged = acted(effect(name, "a.left", **values), block)
    time = np.concatenate(([START], block.time))
    angle = np.concatenate(([5.0], block.angle[:, 0]))
    assert aged["angle"][:, 0] == pytest.approx(np.interp(then, time, angle), abs=1e-12)
    assert np.cumsum(aged["turned"][:, 0]) == pytest.approx(aged["angle"][:, 0] - 5.0, abs=1e-12)


def test_recover_gives_back_the_way_of_a_wheel_whose_samples_are_old(block, acted):
    late = effect("latency", "a.left", delay=0.06)
    aged = acted(late, block)
    back = late.recover(replace(block, travel=0.075 * aged["turned"]))
    way, recovered = np.cumsum(block.travel[:, 0]), np.cumsum(back.travel[:, 0])
    assert recovered[:-5] == pytest.approx(way[:-5], abs=1e-9)


@given(
    st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3),
    st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3),
)
def test_the_truck_is_where_its_reference_says(pose, offset):
    mounted = effect("reference_offset", "a", x=offset[0], y=offset[1], yaw=offset[2])
    assert mounted.truck(mounted.measured(np.array(pose))) == pytest.approx(pose, abs=1e-9)


def test_a_reference_ahead_of_the_axle_runs_round_it_when_the_truck_turns():
    ahead = effect("reference_offset", "a", x=0.1)
    seen = ahead.measured(np.array([[1.0, 2.0, 0.0], [1.0, 2.0, 0.5 * math.pi]]))
    assert seen[:, :2] == pytest.approx(np.array([[1.1, 2.0], [1.0, 2.1]]))


def test_an_edge_of_height_h_loses_2_r_q_minus_sin_q_while_it_rolls_2_r_q():
    q = math.acos(1.0 - 0.010 / 0.075)
    assert crossing_with_loss(0.075, 2.0 * 0.075 * (q - math.sin(q))).rolled == pytest.approx(2.0 * 0.075 * q)
