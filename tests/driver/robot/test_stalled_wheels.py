"""A wheel is frozen where it stands still although its command, or the other wheel, says that it moves."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.driver.robot.stalled_wheels import MIN_TRAVEL, STALL_TIME, StallDetector
from omnimate.vehicle.sample import Sample

NAN = (math.nan, math.nan)


def drive(kit, steps, speeds=None, present=(True, True), samples=200):
    """Return the wheels that are found to stand while each counts so much per sample of 10 ms."""
    watch, found = StallDetector(kit.one_truck()), set()
    for index in range(samples):
        counts = tuple(step * index for step in steps)
        found |= set(watch.check(Sample(index, 0.01 * index, counts, present, NAN, NAN), speeds))
    return {("a.left", "a.right").index(wheel) + 1 for wheel in found}


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


def test_travel_of_the_other_wheel_in_a_gap_of_its_own_does_not_count_as_travel_after_it(kit):
    """Both wheels move until 0.3 s and stand from then on; the other one is not read in between."""
    watch, found = StallDetector(kit.one_truck()), []
    for index in range(120):
        is_read, moved = not 10 <= index < 90, 100 * min(index, 30)
        counts = (moved, moved if is_read else 900)
        found += watch.check(Sample(index, 0.01 * index, counts, (True, is_read), NAN, NAN), None)
    assert found == []


def test_a_command_that_changes_its_direction_is_no_reason_to_move(kit):
    watch = StallDetector(kit.one_truck())
    for index in range(400):
        speed = 4.0 if index // 40 % 2 else -4.0
        sample = Sample(index, 0.01 * index, (0, 0), (True, True), NAN, NAN)
        assert watch.check(sample, (speed, speed)) == []


@given(speed=st.floats(0.1, 10.0), period=st.floats(0.005, 0.05))
def test_a_wheel_is_found_after_the_declared_time_and_way_and_not_before(kit, speed, period):
    watch, radius = StallDetector(kit.one_truck(period=period)), 0.075
    for index in range(2000):
        sample = Sample(index, period * index, (0, 5 * index), (True, True), NAN, NAN)
        if watch.check(sample, (speed, speed)):
            break
    due = max(STALL_TIME, MIN_TRAVEL / (speed * radius)) + period
    assert due - 1e-9 <= sample.time <= due + period + 1e-9


@given(st.tuples(st.integers(1, 300), st.integers(1, 300)), st.booleans())
def test_wheels_that_count_are_never_frozen(kit, steps, is_commanded):
    assert drive(kit, steps, (4.0, 4.0) if is_commanded else None, samples=120) == set()
