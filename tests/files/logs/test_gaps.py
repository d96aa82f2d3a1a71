"""Gaps: from the last good sample to the next one, each with its reason."""

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from omnimate.files.logs.gaps import gaps_of
from omnimate.vehicle.recording import Gap

samples = st.lists(st.tuples(st.booleans(), st.booleans(), st.booleans()), min_size=1, max_size=30)


def gaps(present, received=None, restarts=None):
    nothing = np.zeros(len(present), bool)
    return gaps_of(
        "a.left",
        np.arange(len(present), dtype=float),
        np.array(present, bool),
        np.array(present if received is None else received, bool),
        nothing if restarts is None else np.array(restarts, bool),
    )


def test_samples_that_are_all_present_have_no_gap():
    assert gaps([1, 1, 1]) == []


def test_a_gap_reaches_from_the_last_good_sample_to_the_next_one():
    assert gaps([1, 1, 0, 0, 1, 1]) == [Gap("a.left", 1.0, 4.0, "missing")]


def test_a_reading_that_came_but_was_not_believed_is_a_jump():
    assert gaps([1, 0, 1], received=[1, 1, 1]) == [Gap("a.left", 0.0, 2.0, "jump")]


def test_a_restart_is_a_gap_even_where_no_sample_is_missing():
    assert gaps([1, 1, 1], restarts=[0, 1, 0]) == [Gap("a.left", 0.0, 1.0, "reboot")]


def test_missing_samples_at_the_ends_are_gaps_to_the_ends_of_the_recording():
    assert gaps([0, 1, 0]) == [Gap("a.left", 0.0, 1.0, "missing"), Gap("a.left", 1.0, 2.0, "missing")]


@given(samples)
def test_every_missing_sample_lies_in_a_gap_and_gaps_do_not_overlap(rows):
    present, received, restarts = (list(column) for column in zip(*rows, strict=True))
    result = gaps(present, received, restarts)
    for number, there in enumerate(present):
        assert there or any(gap.start <= number <= gap.end for gap in result)
    assert all(before.end <= after.start for before, after in itertools.pairwise(result))
