"""Filters keep what was asked for and triggers find where it happens."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.files.logs.filters import (
    KINDS,
    FilterError,
    FrameFilter,
    IdentifierRule,
    trigger_of,
    within_seconds,
)
from omnimate.files.logs.frames import ERROR, EXTENDED, REMOTE, Frame, frames_of
from omnimate.files.logs.signals import Signal
from tests.files.logs.any_frames import any_frames

frames = any_frames((0, 0, 0, EXTENDED, REMOTE, ERROR), times=st.floats(0, 1000), directions=(0,))
logs = st.lists(frames, min_size=1, max_size=60).map(frames_of)
SIGNALS = {0x181: [Signal("a.left", 0, 16, signed=True, factor=0.1)]}


def kept(log, **wanted):
    return FrameFilter(**wanted).wants(log).tolist()


@given(log=logs)
def test_without_a_filter_everything_is_wanted(log):
    assert all(kept(log))


@given(log=logs, first=st.integers(0, 0x7FF), last=st.integers(0, 0x7FF))
def test_a_range_and_its_exclusion_divide_the_log(log, first, last):
    first, last = sorted((first, last))
    text = f"{first:03X}-{last:03X}"
    inside, outside = (kept(log, rules=(IdentifierRule.of(rule),)) for rule in (text, f"~{text}"))
    assert [not value for value in inside] == outside
    assert inside == [first <= f.can_id <= last and not f.flags & (EXTENDED | ERROR) for f in log]


@pytest.mark.parametrize("text", ["0x181-0x182", "181h-182h", "0x181-182"])
def test_an_identifier_may_be_marked_as_hexadecimal(text):
    assert IdentifierRule.of(text) == IdentifierRule.of("181-182")


@given(log=logs, code=st.integers(0, 0x7FF), mask=st.integers(0, 0x7FF))
def test_a_mask_is_that_of_candump(log, code, mask):
    wanted = kept(log, rules=(IdentifierRule.of(f"{code:03X}:{mask:03X}"),))
    assert wanted == [f.can_id & mask == code & mask and not f.flags & (EXTENDED | ERROR) for f in log]


@given(log=logs)
def test_every_frame_is_of_exactly_one_kind(log):
    assert np.sum([kept(log, kinds=(kind,)) for kind in KINDS], axis=0).tolist() == [1] * len(log)


def test_a_node_has_its_pdos_sdos_emcys_heartbeats_and_the_nmt_commands_for_it_or_all():
    own = [0x085, 0x185, 0x205, 0x485, 0x505, 0x585, 0x605, 0x705]
    foreign = [0x080, 0x105, 0x186, 0x7E5]
    log = frames_of(
        [Frame(0.0, can_id) for can_id in own + foreign]
        + [Frame(0.0, 0, bytes([1, node])) for node in (5, 0, 6)]
        + [Frame(0.0, 0x185, flags=EXTENDED)]
    )
    assert kept(log, nodes=(5,)) == [True] * 8 + [False] * 4 + [True, True, False, False]


@given(log=logs, begin=st.floats(0, 1000), end=st.floats(0, 1000))
def test_times_count_from_the_first_frame(log, begin, end):
    since = log.time - log.time[0]
    assert kept(log, begin=begin, end=end) == ((since >= begin) & (since <= end)).tolist()


@pytest.mark.parametrize("text", ["", "18G", "800", "200-100", "18:", "~", "20000000", "~~80"])
def test_an_identifier_that_cannot_be_is_refused(text):
    with pytest.raises(FilterError, match="identifier"):
        IdentifierRule.of(text)


def rows(text, log):
    return trigger_of(text, SIGNALS).rows(log).tolist()


def test_a_gap_is_found_where_the_identifier_comes_again():
    log = frames_of([Frame(t, can_id) for t, can_id in ((0, 1), (0.1, 2), (0.2, 1), (0.9, 2), (1.0, 1))])
    assert rows("gap:0.5", log) == [3, 4]
    assert rows("gap:0.75", log) == [3, 4]
    assert rows("gap:0.801", log) == []


def test_an_emergency_that_is_a_reset_triggers_nothing():
    log = frames_of(
        [Frame(0, 0x085, bytes(8)), Frame(1, 0x085, b"\x10\x81" + bytes(6)), Frame(2, 1, flags=ERROR)]
    )
    assert rows("emcy", log) == [1]
    assert rows("error", log) == [2]


def test_a_value_triggers_when_it_begins_to_hold():
    counts = [0, 101, 102, -5, 200]
    log = frames_of(
        [Frame(t, 0x181, count.to_bytes(2, "little", signed=True)) for t, count in enumerate(counts)]
    )
    assert rows("a.left>10", log) == [1, 4]
    assert rows("a.left <= -0.5", log) == [3]


@given(log=logs, cuts=st.lists(st.integers(0, 59), max_size=3))
@pytest.mark.parametrize("text", ["gap:0.5", "gap:40", "emcy", "error", "a.left>10"])
def test_a_trigger_finds_the_same_frames_in_a_log_that_comes_in_blocks(text, log, cuts):
    edges = sorted({0, len(log), *(cut for cut in cuts if cut < len(log))})
    trigger = trigger_of(text, SIGNALS)
    found = [
        start + row
        for start, end in pairwise(edges)
        for row in trigger.rows(log.select(slice(start, end))).tolist()
    ]
    assert found == rows(text, log)


@pytest.mark.parametrize("text", ["gap", "gap:x", "b.left>1", "a.left~1", "", "a.left>"])
def test_a_trigger_that_cannot_be_is_refused(text):
    with pytest.raises(FilterError, match="trigger"):
        rows(text, frames_of([Frame(0, 1)]))


@given(log=logs, chosen=st.sets(st.integers(0, 59)), margin=st.floats(0, 100))
def test_around_keeps_what_is_near_to_one_of_them(log, chosen, margin):
    places = np.array(sorted(place for place in chosen if place < len(log)), np.int64)
    near = [
        bool(np.any((t >= log.time[places] - margin) & (t <= log.time[places] + margin))) for t in log.time
    ]
    assert within_seconds(log, log.time[places], margin).tolist() == near
