"""Counters: true counts come back whatever the width, and impossible readings are rejected."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from omnimate.vehicle.counters import (
    CounterLaw,
    begin_sample,
    counter_law,
    counters_of,
    take_reading,
    unwrap,
)
from omnimate.vehicle.parameters import Bus, Encoder, Linkage, Truck, VehicleParameters

RANGES = st.sampled_from(
    [3, 100, 255, 256, 4096, 10_000, 2**16 - 1, 2**16, 2**24, 2**31, 2**32 - 1, 2**32, 2**62, 2**64]
)


@st.composite
def travels(draw):
    """A range, a largest step below half of it, and true counts that respect it."""
    period = draw(RANGES)
    max_step = draw(st.integers(1, (min(period, 2**33) + 1) // 2 - 1))
    steps = draw(st.lists(st.integers(-max_step, max_step), min_size=1, max_size=50))
    start = draw(st.integers(0, min(period, 2**62) - 1))
    return period, max_step, start + np.concatenate(([0], np.cumsum(steps)))


def follow(law, raw, restarts=()):
    """Return the counts, and whether each reading was believed, and rebased; None is a missing one."""
    counter = counters_of([law])[0]
    rows = []
    for index, reading in enumerate(raw):
        begin_sample(counter)
        counter["has_restarted"] |= index in restarts
        if reading is not None:
            take_reading(counter, int(reading))
        rows.append((int(counter["count"]), bool(counter["present"]), bool(counter["rebased"])))
    return [list(column) for column in zip(*rows, strict=True)]


@given(travels())
def test_true_counts_come_back_at_any_range_and_in_both_directions(case):
    period, max_step, truth = case
    law = CounterLaw((period,), max_step, absolute=False)
    raw = truth if period > 2**62 else truth % period
    assert np.array_equal(unwrap(raw, law), truth)


@given(travels())
def test_signed_fields_unwrap_like_unsigned_ones(case):
    period, max_step, truth = case
    law = CounterLaw((period,), max_step, absolute=False)
    signed = truth if period > 2**62 else (truth + period // 2) % period - period // 2
    assert np.array_equal(np.diff(unwrap(signed, law)), np.diff(truth))


@given(st.integers(2, 2**16).map(lambda half: 2 * half), st.booleans(), st.integers(0, 2**17))
def test_a_jump_of_half_the_range_is_rejected(period, upwards, start):
    law = CounterLaw((period,), period, absolute=False)
    jump = period // 2 if upwards else -(period // 2)
    counts, present, _ = follow(law, [start % period, (start + jump) % period, start % period])
    assert present == [True, False, True]
    assert len(set(counts)) == 1


def test_a_spike_is_rejected_and_costs_no_travel():
    law = CounterLaw((2**32,), 50, absolute=False)
    counts, present, _ = follow(law, [0, 10, 90_000, 30, 40])
    assert counts == [0, 10, 10, 30, 40]
    assert present == [True, True, False, True, True]


def test_an_unannounced_restart_rebaselines_a_wheel_but_not_an_absolute_encoder():
    raw = [5000, 5010, 3, 13, 23]
    counts, _, rebased = follow(CounterLaw((2**32,), 50, absolute=False), raw)
    assert counts == [5000, 5010, 5010, 5010, 5020]
    assert rebased == [False, False, False, True, False]
    assert follow(CounterLaw((2**32,), 50, absolute=True), raw)[0] == [5000, 5010, 5010, 13, 23]


def test_an_announced_restart_never_moves_a_wheel():
    law = CounterLaw((2**32,), 50, absolute=False)
    counts, present, rebased = follow(law, [100, 110, 7, 17], restarts={2})
    assert counts == [100, 110, 110, 120]
    assert rebased == [False, False, True, False]
    assert all(present)


def test_missing_readings_hold_the_count_and_the_next_one_spans_them():
    law = CounterLaw((2**32,), 10, absolute=False)
    assert follow(law, [0, 10, None, None, 38])[0] == [0, 10, 10, 10, 38]


def test_a_joint_wraps_at_its_turn_and_at_its_width():
    law = CounterLaw((2**16, 10_000), 2000, absolute=True)
    assert unwrap([9_990, 5], law).tolist() == [9_990, 10_005]
    assert unwrap([2**16 - 5, 5], law).tolist() == [2**16 - 5, 2**16 + 5]


@given(st.integers(1, 10_000), st.integers(0, 20), st.sampled_from([-1, 1]))
def test_each_sample_allows_the_largest_step_and_not_one_count_more(largest, missed, sign):
    law = CounterLaw((2**32,), largest, absolute=False)
    step = sign * largest * (missed + 1)
    assert follow(law, [7, *[None] * missed, 7 + step])[1][-1]
    assert not follow(law, [7, *[None] * missed, 7 + step + sign])[1][-1]
    assert not follow(law, [7, *[None] * missed, 7 + step, 7 + step + sign * (largest + 1)])[1][-1]


def test_a_reading_goes_on_from_a_rejected_one_by_one_step_at_most():
    law = CounterLaw((2**32,), 50, absolute=False)
    assert follow(law, [0, 10, 90_000, 90_051, 90_101])[1] == [True, True, False, False, True]


@given(st.integers(1, 499), st.lists(st.integers(-1, 1), min_size=1, max_size=3))
def test_the_samples_count_as_ambiguous_in_which_it_may_have_moved_by_half_of_its_range(largest, deviations):
    counter = counters_of([CounterLaw((1000,), largest, absolute=False)])[0]
    take_reading(counter, 7)
    gaps = [max(round(500 / largest) + deviation, 1) for deviation in deviations]
    for samples in gaps:
        for _ in range(samples):
            begin_sample(counter)
        take_reading(counter, 7)
    assert counter["ambiguous"] == sum(samples for samples in gaps if samples * largest >= 500)


def test_fields_wrap_up_to_62_bits_and_wider_ones_are_taken_as_they_are():
    narrow = CounterLaw((2**62,), 50, absolute=False)
    assert unwrap([2**62 - 5, 5], narrow).tolist() == [2**62 - 5, 2**62 + 5]
    for bits in (63, 64):
        assert unwrap([5, 9], CounterLaw((2**bits,), 50, absolute=False)).tolist() == [5, 9]


WHEELS = ("a.left", "a.right", "b.left", "b.right")
UNITS = dict.fromkeys((*WHEELS, "joint_a", "joint_b"), "counts_per_turn") | {"link": "counts_per_metre"}


def law_of(channel, counts, bits=16):
    """Return the law of an encoder, of these counts per turn or metre, on a robot with a SYNC every 10 ms."""
    encoders = [
        Encoder(name, node, 0x180 + node, 0, bits, signed=False, sign=-1, **{unit: counts})
        for node, (name, unit) in enumerate(UNITS.items(), start=1)
    ]
    trucks = {"a": Truck(0.3, 0.2, 0.2), "b": Truck(0.3, 0.2, 0.2)}
    vehicle = VehicleParameters("r", trucks, Linkage(1.0), Bus(500_000, 0.01), tuple(encoders))
    return counter_law(vehicle.encoder(channel), vehicle)


@given(st.floats(1.0, 10_000.0))
def test_a_step_is_as_long_as_10_metres_and_20_radians_per_second_make_it(counts):
    """One count is always possible, however coarse the encoder is."""
    for channel, step, is_absolute in (
        ("a.left", 10.0 * 0.01 * counts / (np.pi * 0.2), False),
        ("joint_a", 20.0 * 0.01 * counts / (2.0 * np.pi), True),
        ("link", 10.0 * 0.01 * counts, True),
    ):
        law = law_of(channel, counts)
        assert step - 1.001 < law.max_step < max(step, 1.0) + 0.001
        assert law.max_step >= 1
        assert law.absolute == is_absolute


def test_only_a_joint_with_whole_counts_per_turn_has_its_turn_as_a_range():
    assert law_of("joint_b", 10_000.0).periods == (2**16, 10_000)
    assert law_of("joint_b", 10_000.5).periods == (2**16,)
    assert law_of("a.left", 10_000.0).periods == (2**16,)
    assert law_of("link", 10_000.0).periods == (2**16,)
