"""The rates of identifiers, of a whole log or block by block."""

from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from omnimate.files.logs.decoding import FrameDecoder
from omnimate.files.logs.frames import SENT, Frame, frames_of
from omnimate.files.logs.rates import RateTable, without_pauses
from tests.files.logs.any_frames import CLASSICAL, logs


def lines(*blocks):
    table = RateTable()
    for block in blocks:
        table.add(block)
    return list(table.lines(FrameDecoder()))


@given(
    log=logs(kinds=CLASSICAL, directions=(0, SENT)).map(frames_of),
    cuts=st.lists(st.integers(0, 59), max_size=3),
)
def test_the_rates_are_the_same_in_a_log_that_comes_in_blocks(log, cuts):
    edges = sorted({0, len(log), *(cut for cut in cuts if cut < len(log))})
    assert lines(*(log.select(slice(start, end)) for start, end in pairwise(edges))) == lines(log)


@given(
    interval=st.floats(0.001, 0.5),
    pauses=st.lists(st.sampled_from([0.9, 2.0, 4.0, 60.0]), max_size=3),
    count=st.integers(20, 60),
)
def test_the_rate_is_the_mean_without_pauses(interval, pauses, count):
    intervals = np.array([*[interval] * count, *pauses])
    times = np.concatenate(([0.0], np.cumsum(intervals)))
    there = without_pauses(intervals)
    row = lines(frames_of(Frame(float(time), 0x181) for time in times))[1]
    printed = float(row.split()[3])
    near_limit = np.any(np.abs(np.array(pauses) / (10 * interval) - 1) < 0.06)
    assert near_limit or abs(printed - len(there) / there.sum()) < 0.001 + 1e-6 * printed
