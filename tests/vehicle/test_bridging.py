"""Travel that a restarted counter lost: the other wheel's, in the proportion of the ten samples before."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vehicle.bridging import BridgedCounter, bridge, set_partners
from omnimate.vehicle.counters import CounterLaw, begin_sample, counters_of, take_reading

LAW = CounterLaw((2**32,), 10_000, absolute=False)
NARROW = CounterLaw((1000,), 300, absolute=False)  # ambiguous after one lost sample
STEPS = st.integers(-50, 50)
PATHS = st.lists(st.tuples(STEPS, STEPS), min_size=1, max_size=30)
GAPS = st.lists(st.tuples(STEPS, STEPS), max_size=5)
SCALES = st.sampled_from([(1.0, 1.0), (1.0, -2.0), (-2.0, 1.0)])


class Truck:
    """Two wheel counters, which are read in each sample unless they are missing."""

    def __init__(self, scales=(1.0, 1.0), law=LAW):
        self.counters = counters_of([law, law], BridgedCounter)
        self.counters["partner"], self.counters["scale"] = (1, 0), scales
        self.number = 0

    def sample(self, *raw, restarted=()):
        """Take the raw readings, None for a missing one; return the counts and what was lost."""
        for column, reading in enumerate(raw):
            counter = self.counters[column]
            begin_sample(counter)
            counter["has_restarted"] |= column in restarted
            if reading is not None:
                take_reading(counter, reading)
        read = self.counters["count"].copy()
        bridge(self.counters, self.number)
        self.number += 1
        return self.counters["count"].tolist(), (self.counters["count"] - read).tolist()


def proportional(path, travel, scales):
    """Return the counts that the first wheel lost while the other one travelled; `path`: `(N, 2)`."""
    before = path[-1] - path[max(len(path) - 11, 0)]
    if before[1] == 0 or abs(before[0] * scales[0]) > 4.0 * abs(before[1] * scales[1]):
        return 0
    return int(np.rint(travel * before[0] / before[1]))


@given(PATHS, GAPS, PATHS, GAPS, SCALES)
def test_a_wheel_loses_what_the_other_one_makes_in_the_proportion_of_the_ten_samples_before(
    first, gap, second, second_gap, scales
):
    """Also at the second time, when the ten samples may reach back to before the first restart."""
    truck, path, raw = Truck(scales), [np.array([70, -30])], np.array([70, -30])
    truck.sample(*raw)
    for steps, missed in ((first, gap), (second, second_gap)):
        for step in steps:
            raw = raw + step
            path.append(path[-1] + step)
            assert truck.sample(*raw) == (path[-1].tolist(), [0, 0])
        start = path[-1]
        lost_path = np.array(path)
        for step in missed:
            raw = raw + step
            path.append(np.array([start[0], path[-1][1] + step[1]]))
            assert truck.sample(None, raw[1]) == (path[-1].tolist(), [0, 0])
        raw = np.array([5, raw[1] + 20])
        travel = path[-1][1] + 20 - start[1]
        lost = proportional(lost_path, travel, scales)
        path.append(np.array([start[0] + lost, start[1] + travel]))
        assert truck.sample(*raw, restarted=[0]) == (path[-1].tolist(), [lost, 0])


@pytest.mark.parametrize(("travel", "is_estimated"), [(160, True), (161, False), (-160, True), (-161, False)])
@pytest.mark.parametrize("column", [0, 1])
def test_a_wheel_that_travels_four_times_as_far_as_the_other_one_is_the_limit(column, travel, is_estimated):
    scales = (0.5, -2.0)[:: 1 - 2 * column]
    truck = Truck(scales)
    in_order = slice(None, None, 1 - 2 * column)  # the first number of each pair is the restarted wheel's
    truck.sample(0, 0)
    truck.sample(*(travel, 10)[in_order])
    _, lost = truck.sample(*(7, 20)[in_order], restarted=[column])
    assert lost[in_order] == [travel if is_estimated else 0, 0]


def test_nothing_is_estimated_where_both_wheels_restart_in_the_same_gap():
    truck = Truck()
    for count in range(0, 100, 10):
        truck.sample(count, count)
    assert truck.sample(None, 3, restarted=[1]) == ([90, 90], [0, 0])
    assert truck.sample(5, 13, restarted=[0]) == ([90, 100], [0, 0])
    truck.sample(15, 23)
    lost = round(10 * (100 - 20) / (110 - 20))  # of the ten samples before, of which one was lost
    assert truck.sample(5, 33, restarted=[0])[1] == [lost, 0], "estimated again after a sample with both"


def test_nothing_is_estimated_where_the_wheels_were_never_read_together():
    truck = Truck()
    for count in range(0, 100, 10):
        truck.sample(count, None)
    assert truck.sample(5, 13, restarted=[0]) == ([90, 13], [0, 0])


def test_a_restart_loses_no_travel_that_the_wheel_counted_while_the_other_one_was_not_read():
    truck = Truck()
    for count in range(0, 100, 10):
        truck.sample(count, count)
    truck.sample(190, None)
    assert truck.sample(5, 200, restarted=[0]) == ([200, 200], [10, 0])


def test_nothing_is_estimated_while_the_other_wheel_is_not_read_and_this_one_has_counted_on():
    truck = Truck()
    for count in range(0, 100, 10):
        truck.sample(count, count)
    truck.sample(190, None)
    assert truck.sample(5, None, restarted=[0]) == ([190, 90], [0, 0])


def test_a_restart_in_a_sample_that_the_other_wheel_missed_loses_its_travel_up_to_its_last_reading():
    truck = Truck()
    for count in range(0, 100, 10):
        truck.sample(count, count)
    truck.sample(None, 120)
    assert truck.sample(5, None, restarted=[0]) == ([120, 120], [30, 0])


@given(st.integers(-30, 30), st.integers(3, 200), st.integers(-490, 490))
def test_the_ranges_that_a_counter_passes_while_it_is_not_read_are_known_by_the_other_wheel(
    speed, missed, deviation
):
    """The two wheels may differ by less than half of a range; speed in tens of counts per sample."""
    truck, step = Truck(law=NARROW), 10 * speed or 10
    assume((missed * step + deviation) % 1000 != 500)  # a step of exactly half a range is no step
    for number in range(-12, 1):
        truck.sample(number * step % 1000, number * step % 1000)
    start = truck.counters["count"].tolist()
    for number in range(1, missed):
        truck.sample(None, number * step % 1000)
    travel = missed * step
    counts, _ = truck.sample((travel + deviation) % 1000, travel % 1000)
    assert [after - before for after, before in zip(counts, start, strict=True)] == [
        travel + deviation,
        travel,
    ]


def travel_straight_on(column, missed, other_missed, restart=None):
    """Return the travel of a wheel, in `column`, and of the other one in 60 samples of 100 counts each.

    Each is not read in the samples that it missed; the wheel's counter restarts in sample `restart`.
    """
    truck, start, in_order = Truck(law=NARROW), [0, 0], slice(None, None, 1 - 2 * column)
    for number in range(-10, 61):
        count = number * 100
        reading = count if restart is None or number < restart else count - 777
        read = [
            None if number in missed else reading % 1000,
            None if number in other_missed else count % 1000,
        ]
        counts, _ = truck.sample(*read[in_order], restarted=[column] if number == restart else [])
        start = counts if number == 0 else start
    return [count - first for count, first in zip(counts, start, strict=True)][in_order]


@pytest.mark.parametrize("column", [0, 1])
@pytest.mark.parametrize("missed", [{51}, {50, 51, 52}, {20, 21, 22}])
def test_passed_ranges_are_known_although_the_other_wheel_missed_a_few_samples_too(column, missed):
    assert travel_straight_on(column, missed, range(1, 51)) == [6000, 6000]


@pytest.mark.parametrize("column", [0, 1])
def test_passed_ranges_are_known_although_the_other_wheel_has_restarted_meanwhile(column):
    """What that one lost in its restart remains lost, as the wheel was not read."""
    assert travel_straight_on(column, {20, 21}, range(1, 51), restart=22) == [5700, 6000]


@pytest.mark.parametrize("column", [0, 1])
def test_what_a_wheel_counted_before_its_restart_is_the_travel_of_one_that_passed_ranges_unread(column):
    """Both are read again in sample 51; how many ranges were passed after sample 21 is unknown."""
    assert travel_straight_on(column, range(22, 51), range(1, 51), restart=51) == [3000, 3000]


@pytest.mark.parametrize("column", [0, 1])
def test_a_wheel_that_counted_on_keeps_its_count_where_the_other_one_comes_back_after_a_restart(column):
    """Both were not read for a while, this one for less; the other one's restart says nothing of it."""
    truck = Truck(law=NARROW)
    for count in range(0, 1200, 100):
        truck.sample(count, count)
    for count in range(1200, 4700, 100):
        is_back = count >= 1400
        truck.sample(*((count if is_back and number == column else None) for number in (0, 1)))
    counts, _ = truck.sample(
        *((4700 if number == column else 7) for number in (0, 1)), restarted=[1 - column]
    )
    assert counts == [4700, 4700]


def test_no_range_is_added_where_the_other_wheel_says_nothing():
    """It is not read either, or it is back in the same sample and may have passed its range, too."""
    for back in (None, 90):
        truck = Truck(law=NARROW)
        for count in range(0, 100, 10):
            truck.sample(count, count)
        for count in range(190, 5000, 100):
            truck.sample(count % 1000, None)
        assert truck.counters["count"][0] == 4990
        for _ in range(5):
            truck.sample(None, None)
        assert truck.sample(90, back)[0][0] == 5090


def test_no_range_is_added_where_both_wheels_missed_the_same_samples():
    truck = Truck(law=NARROW)
    for count in range(0, 500, 100):
        truck.sample(count, count)
    for _ in range(4):
        truck.sample(None, None)
    assert truck.sample(800, 0) == ([800, 0], [0, 0])


def test_the_partner_of_a_wheel_is_the_other_one_of_its_truck_and_encoders_of_the_linkage_have_none():
    vehicle = reference_vehicle()
    counters = counters_of([LAW] * len(vehicle.channels), BridgedCounter)
    set_partners(counters, vehicle)
    found = dict(zip(vehicle.channels, counters[["partner", "scale"]].tolist(), strict=True))
    names = {"a.left": "a.right", "a.right": "a.left", "b.left": "b.right", "b.right": "b.left"}
    for channel, (partner, scale) in found.items():
        if channel in names:
            assert vehicle.channels[partner] == names[channel]
            assert scale == vehicle.metres_per_count(channel)
        else:
            assert partner == -1
