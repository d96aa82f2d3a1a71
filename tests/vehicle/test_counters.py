"""Counters: one law for a whole channel and for reading by reading, whatever the width."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from omnimate.vehicle.counters import Counter, CounterLaw, unwrap

RANGES = st.sampled_from([3, 100, 255, 256, 4096, 10_000, 2**16 - 1, 2**16, 2**24, 2**31, 2**32 - 1, 2**32])


@st.composite
def travels(draw):
    """A range, a largest step below half of it, and true counts that respect it."""
    period = draw(RANGES)
    max_step = draw(st.integers(1, (period + 1) // 2 - 1))
    steps = draw(st.lists(st.integers(-max_step, max_step), min_size=1, max_size=50))
    start = draw(st.integers(0, period - 1))
    return period, max_step, start + np.concatenate(([0], np.cumsum(steps)))


def follow(law, raw, present=None, restarts=None):
    counter = Counter(law)
    believed, counts, rebased = [], [], []
    for index, value in enumerate(raw):
        if restarts is not None and restarts[index]:
            counter.rebase()
        believed.append(counter.step(int(value) if present is None or present[index] else None))
        counts.append(counter.count)
        rebased.append(counter.rebased)
    return believed, counts, rebased


@given(travels())
def test_true_counts_come_back_at_any_range_and_in_both_directions(case):
    period, max_step, truth = case
    law = CounterLaw((period,), max_step, absolute=False)
    assert np.array_equal(unwrap(truth % period, law).counts, truth)


@given(travels())
def test_signed_fields_unwrap_like_unsigned_ones(case):
    period, max_step, truth = case
    law = CounterLaw((period,), max_step, absolute=False)
    signed = (truth + period // 2) % period - period // 2
    assert np.array_equal(np.diff(unwrap(signed, law).counts), np.diff(truth))


@given(st.integers(2, 2**16).map(lambda half: 2 * half), st.booleans(), st.integers(0, 2**17))
def test_a_jump_of_half_the_range_is_rejected(period, upwards, start):
    law = CounterLaw((period,), period, absolute=False)
    jump = period // 2 if upwards else -(period // 2)
    result = unwrap([start % period, (start + jump) % period, start % period], law)
    assert result.present.tolist() == [True, False, True]
    assert len(set(result.counts.tolist())) == 1


@given(
    st.lists(
        st.tuples(st.integers(0, 255), st.booleans(), st.integers(0, 9).map(lambda n: n == 0)),
        min_size=1,
        max_size=60,
    ),
    st.integers(1, 127),
    st.booleans(),
    st.sampled_from([(256,), (256, 64), (256, 100)]),
)
def test_whole_channel_and_reading_by_reading_agree_on_anything(rows, max_step, absolute, periods):
    raw, present, restarts = (list(column) for column in zip(*rows, strict=True))
    law = CounterLaw(periods, max_step, absolute)
    whole = unwrap(raw, law, present, restarts)
    believed, counts, rebased = follow(law, raw, present, restarts)
    assert whole.present.tolist() == believed
    assert whole.rebased.tolist() == rebased
    if any(believed):
        first = believed.index(True)
        assert whole.counts.tolist() == [counts[first]] * first + counts[first:]


def test_a_spike_is_rejected_and_costs_no_travel():
    law = CounterLaw((2**32,), 50, absolute=False)
    result = unwrap([0, 10, 90_000, 30, 40], law)
    assert result.counts.tolist() == [0, 10, 10, 30, 40]
    assert result.present.tolist() == [True, True, False, True, True]


def test_an_unannounced_restart_rebaselines_a_wheel_but_not_an_absolute_encoder():
    raw = [5000, 5010, 3, 13, 23]
    wheel = unwrap(raw, CounterLaw((2**32,), 50, absolute=False))
    assert wheel.counts.tolist() == [5000, 5010, 5010, 5010, 5020]
    assert wheel.rebased.tolist() == [False, False, False, True, False]
    joint = unwrap(raw, CounterLaw((2**32,), 50, absolute=True))
    assert joint.counts.tolist() == [5000, 5010, 5010, 13, 23]


def test_an_announced_restart_never_moves_a_wheel():
    law = CounterLaw((2**32,), 50, absolute=False)
    result = unwrap([100, 110, 7, 17], law, restarts=[False, False, True, False])
    assert result.counts.tolist() == [100, 110, 110, 120]
    assert result.present.all()


def test_missing_readings_hold_the_count_and_the_next_one_spans_them():
    law = CounterLaw((2**32,), 10, absolute=False)
    result = unwrap([0, 10, 0, 0, 38], law, present=[True, True, False, False, True])
    assert result.counts.tolist() == [0, 10, 10, 10, 38]


def test_a_joint_wraps_at_its_turn_and_at_its_width():
    single_turn = CounterLaw((2**16, 10_000), 2000, absolute=True)
    assert unwrap([9_990, 5], single_turn).counts.tolist() == [9_990, 10_005]
    multi_turn = CounterLaw((2**16, 10_000), 2000, absolute=True)
    assert unwrap([2**16 - 5, 5], multi_turn).counts.tolist() == [2**16 - 5, 2**16 + 5]
