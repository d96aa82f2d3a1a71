"""Which frame answers a SYNC: sample by sample as over a whole log, and never a late one of a burst."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from omnimate.files.logs.answers import Owed, current

PERIOD = 0.01


def stepwise(frames, first, last):
    """What the assembler does live."""
    owed, places = Owed(PERIOD), []
    for number, early, late in zip(frames, first, last, strict=True):
        if number and not owed.count:
            owed.usual = early
            places.append(0)
        else:
            place = owed.close(number, late)
            places.append(-1 if place is None else place)
    return places


latencies = st.floats(0.0, 0.0099)


@given(st.lists(st.tuples(st.integers(0, 4), latencies, latencies), min_size=1, max_size=60))
def test_a_whole_log_gives_what_it_gives_sample_by_sample(rows):
    frames = [number for number, _, _ in rows]
    first = [min(a, b) if number else math.nan for number, a, b in rows]
    last = [max(a, b) if number else math.nan for number, a, b in rows]
    places = current(np.array(frames), np.array(first), np.array(last), PERIOD)
    assert places.tolist() == stepwise(frames, first, last)


@given(silent=st.integers(2, 60), begun=st.integers(1, 60), latency=st.floats(0.004, 0.0099))
def test_a_burst_of_late_answers_never_counts_as_current(silent, begun, latency):
    """The first frames of it come late in one sample, the others in the next, before its own answer."""
    begun = min(begun, silent)
    frames = [1, *[0] * silent, begun, silent - begun + 2, 1]
    first = [0.001, *[math.nan] * silent, latency, 0.0001, 0.001]
    places = stepwise(frames, first, first)
    assert places[silent + 1] == -1
    assert places[silent + 2] == silent - begun + 1  # the last frame is the answer to this SYNC
    assert places[silent + 3] == 0


@given(lost=st.integers(1, 60), later=st.integers(0, 1))
def test_answers_that_were_lost_are_not_waited_for(lost, later):
    """A node that answers again as before counts at once, and one that answers later at the second time."""
    latency = 0.001 + 0.005 * later
    frames = [1, *[0] * lost, 1, 1]
    times = [0.001, *[math.nan] * lost, latency, latency]
    waited = int(later and lost > 1)
    assert stepwise(frames, times, times)[-2:] == ([-1, 0] if waited else [0, 0])
