"""How errors of a known form enter a step: what a late or slipping wheel gains comes to nothing at a stop."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.ipec.filter.forms import fill_sensitivities, fill_speeds
from omnimate.ipec.filter.hypotheses import (
    ENCODERS,
    HYPOTHESES,
    LATE,
    LINK_SCALE,
    OFF_CENTRE,
    PLAY,
    PUSH,
    SLOPE,
    TRUCKS,
    WANDERS,
)
from omnimate.ipec.filter.live import Filter
from omnimate.ipec.filter.records import AHEAD, INPUTS, JOINT_A, LENGTH, LINK, SIDES, WANDER
from omnimate.vcan_sim.reference import reference_vehicle


def number_of(reading, form):
    return next(
        number for number, each in enumerate(HYPOTHESES) if (each.reading, each.form) == (reading, form)
    )


@pytest.fixture(scope="module")
def start():
    filter_ = Filter(reference_vehicle())
    return filter_.settings, filter_.start()


def step(start, states, filters, number, *, way=(0.0,) * 4, rolled=(0.0,) * 4, joint=(0.0, 0.0)):
    states["step_start"][0] = states["mean"][0, LINK : LINK + 4]
    states["mean"][0, JOINT_A : JOINT_A + 2] += joint
    states["step_travel"][0], states["step_distance"][0], states["samples"] = way, rolled, 5
    fill_speeds(start[0][0], states[0])
    fill_sensitivities(states[0], filters[number])
    return filters[number]


speeds = st.lists(st.floats(-0.05, 0.05), min_size=1, max_size=10)


@settings(max_examples=50)
@given(ways=speeds, wheel=st.integers(0, 3))
def test_what_a_late_or_slipping_wheel_has_gained_depends_on_its_speed_alone(start, ways, wheel):
    states, filters = start[1].record.copy(), start[1].filters.copy()
    number, gained = number_of(ENCODERS + wheel, LATE), np.zeros((INPUTS, 2))
    for way in ways:
        gained += step(start, states, filters, number, way=np.eye(4)[wheel] * way)["input_sensitivity"]
    speed = ways[-1] / (5 * start[0]["period"][0])
    assert gained[wheel] == pytest.approx([speed, -0.5 * speed * abs(speed)], abs=1e-12)
    assert not np.delete(gained, wheel, axis=0).any()


@pytest.mark.parametrize("truck", [0, 1])
def test_a_truck_that_slips_moves_as_its_two_wheels_together(start, truck):
    """With unequal speeds each wheel errs by its own; a step is moved by the sum of both."""
    ways = np.array([0.04, 0.05, 0.03, 0.02])
    moved = np.zeros((6, 2))
    for reading in (TRUCKS + truck, ENCODERS + 2 * truck, ENCODERS + 2 * truck + 1):
        states, filters = start[1].record.copy(), start[1].filters.copy()
        states["inputs"][0] = np.random.default_rng(0).normal(size=(6, 8))
        step(start, states, filters, number_of(reading, LATE), way=ways)
        moved += (1.0 if reading < ENCODERS else -1.0) * states["transition"][0, :, WANDER : WANDER + 2]
    assert moved == pytest.approx(np.zeros((6, 2)), abs=1e-12)
    assert np.abs(states["transition"][0, :, WANDER : WANDER + 2]).max() > 0.1


@settings(max_examples=50)
@given(angle=st.floats(-1.0, 1.0), joint=st.integers(0, 1), turn=st.floats(-0.1, 0.1))
def test_off_the_centre_is_any_phase(start, angle, joint, turn):
    states, filters = start[1].record.copy(), start[1].filters.copy()
    states["mean"][0, JOINT_A + joint] = angle
    moved = np.eye(2)[joint] * turn
    by_sizes = step(start, states, filters, number_of(joint, OFF_CENTRE), joint=moved)["reading_sensitivity"][
        :, joint
    ]
    middle = angle + 0.5 * turn
    assert by_sizes == pytest.approx([np.sin(middle), np.cos(middle)])


@settings(max_examples=50)
@given(turns=st.lists(st.floats(-0.02, 0.02), max_size=10), side=st.sampled_from([-1.0, 1.0]))
def test_a_joint_that_moved_by_its_play_reads_it_to_that_side(start, turns, side):
    """Within its play it may read anything up to the half of it; at a side nothing is added."""
    states, filters = start[1].record.copy(), start[1].filters.copy()
    number, half = number_of(0, PLAY), 0.01
    filters[number]["covariance"][WANDER, WANDER] = half**2
    for turn in turns:
        opened = step(start, states, filters, number, joint=(turn, 0.0))
        assert -1.0 <= opened["reading_sensitivity"][0, 0] <= 1.0
        assert 0.0 <= opened["form_variance"] <= half**2
    for _ in range(2):
        opened = step(start, states, filters, number, joint=(side * 2.0 * half, 0.0))
    assert opened["reading_sensitivity"][0, 0] == pytest.approx(-side)
    assert opened["form_variance"] == pytest.approx(0.0, abs=1e-12)
    opened = step(start, states, filters, number, joint=(-side * 2.0 * half, 0.0))
    assert opened["form_variance"] == pytest.approx(half**2)


@settings(max_examples=50)
@given(heading=st.floats(-4.0, 4.0), turn=st.floats(-0.05, 0.05), truck=st.integers(0, 1), back=st.booleans())
def test_a_truck_on_a_slope_creeps_by_its_way_along_x_and_along_y(start, heading, turn, truck, back):
    """Ahead and to the side together are the floor's direction, whichever way the truck looks and drives."""
    states, filters = start[1].record.copy(), start[1].filters.copy()
    states["mean"][0, LINK], states["mean"][0, JOINT_A + truck] = heading, 0.3
    way = (-0.04 if back else 0.04,) * 4
    number, moved = number_of(TRUCKS + truck, SLOPE), np.eye(2)[truck] * turn
    gained = step(start, states, filters, number, way=way, joint=moved)["input_sensitivity"]
    angle = heading + 0.3 + 0.5 * turn
    axes = np.array([[-np.sin(angle), np.cos(angle)], [np.cos(angle), np.sin(angle)]])  # to the side, ahead
    assert axes.T @ gained[[SIDES + truck, AHEAD + truck]] == pytest.approx(0.04 * np.eye(2), abs=1e-12)


@settings(max_examples=50)
@given(angles=st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)), creep=st.floats(-0.05, 0.05))
def test_trucks_that_push_each_other_creep_along_the_link_by_opposite_ways(start, angles, creep):
    """In the link's frame: a along the link, b as much back; the second size moves both alike."""
    states, filters = start[1].record.copy(), start[1].filters.copy()
    states["mean"][0, JOINT_A : JOINT_A + 2] = angles
    number = number_of(2, PUSH)
    filters[number]["offset"][WANDER] = creep
    gained = step(start, states, filters, number, way=(0.04,) * 4, rolled=(0.04,) * 4)["input_sensitivity"]
    for truck, away in enumerate((1.0, -1.0)):
        ahead, aside = gained[AHEAD + truck], gained[SIDES + truck]
        cos, sin = np.cos(angles[truck]), np.sin(angles[truck])
        assert ahead * cos - aside * sin == pytest.approx([0.04 * away, 0.04 * creep], abs=1e-12)
        assert ahead * sin + aside * cos == pytest.approx([0.0, 0.0], abs=1e-12)


@settings(max_examples=50)
@given(rates=st.tuples(*[st.floats(-0.05, 0.05)] * 2), delay=st.floats(0.0, 10.0))
def test_a_late_joint_lags_at_the_rate_of_the_step_before(start, rates, delay):
    """The step's own rate answers what the reading shows; at a steady rate nothing is unsure."""
    states, filters = start[1].record.copy(), start[1].filters.copy()
    number, time = number_of(1, LATE), 5 * start[0]["period"][0]
    filters[number]["offset"][WANDER] = delay * time
    for turn in rates:
        opened = step(start, states, filters, number, joint=(0.0, turn))
    before, now = np.array(rates) / time
    assert opened["reading_sensitivity"][0, 1] == pytest.approx(-before, abs=1e-12)
    assert opened["form_variance"] == pytest.approx((delay * time * (now - before)) ** 2 / 3.0, abs=1e-15)


def test_a_links_scale_acts_on_its_extension_before_the_errors_that_the_floor_still_makes(start):
    states, filters = start[1].record.copy(), start[1].filters.copy()
    lengths = start[0]["length"][0] + np.array([0.03, -0.01, 0.02, 0.0, 0.05])
    seen = []
    for length in lengths:
        states["mean"][0, LENGTH] = length
        opened = step(start, states, filters, number_of(2, LINK_SCALE))
        seen.append(opened["reading_sensitivity"][0, 2])
    assert seen == pytest.approx([0.0, 0.0, 0.0, 0.03, -0.01])


@pytest.mark.parametrize("wheel", range(4))
def test_a_wheel_whose_size_changes_gains_a_part_of_its_way(start, wheel):
    states, filters = start[1].record.copy(), start[1].filters.copy()
    ways = np.array([0.04, -0.05, 0.03, 0.02])
    gained = step(start, states, filters, number_of(ENCODERS + wheel, WANDERS), way=ways)["input_sensitivity"]
    assert gained[wheel] == pytest.approx([ways[wheel], 0.0])
    assert not np.delete(gained, wheel, axis=0).any()
