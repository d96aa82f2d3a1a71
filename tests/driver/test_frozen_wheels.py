"""A wheel is frozen where it stands still although its command, or the other wheel, says that it moves."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.driver.event_log import EventLog
from omnimate.driver.frozen_wheels import FrozenWheelWatch
from omnimate.vehicle.sample import Sample

NAN = (math.nan, math.nan)


def drive(kit, steps, speeds=None, present=(True, True), samples=200):
    """Return the nodes that are reported while each wheel counts so much per sample of 10 ms."""
    events = EventLog()
    watch = FrozenWheelWatch(kit.one_truck(), events)
    for index in range(samples):
        counts = tuple(step * index for step in steps)
        watch.check(Sample(index, 0.01 * index, counts, present, NAN, NAN), speeds)
    return {event.node for event in events.all()}


@pytest.mark.parametrize(("steps", "nodes"), [((0, 100), {1}), ((100, 0), {2}), ((0, 0), set())])
def test_without_commands_the_other_wheel_shows_that_a_wheel_is_frozen(kit, steps, nodes):
    assert drive(kit, steps) == nodes


@pytest.mark.parametrize(
    ("speeds", "nodes"), [((4.0, 4.0), {1, 2}), ((4.0, 0.0), {1}), ((0.0, 0.0), set()), ((0.01, 0.01), set())]
)
def test_with_commands_a_wheel_that_stands_must_be_commanded_to_stand(kit, speeds, nodes):
    assert drive(kit, (0, 0), speeds) == nodes


def test_a_wheel_that_was_not_read_is_not_called_frozen(kit):
    assert drive(kit, (0, 100), present=(False, True)) == set()


def test_a_command_that_changes_its_direction_is_no_reason_to_move(kit):
    events = EventLog()
    watch = FrozenWheelWatch(kit.one_truck(), events)
    for index in range(20):
        speed = 4.0 if index % 2 else -4.0
        watch.check(Sample(index, 0.5 * index, (0, 0), (True, True), NAN, NAN), (speed, speed))
    assert events.all() == ()


@given(st.tuples(st.integers(1, 300), st.integers(1, 300)), st.booleans())
def test_wheels_that_count_are_never_frozen(kit, steps, is_commanded):
    assert drive(kit, steps, (4.0, 4.0) if is_commanded else None, samples=120) == set()
