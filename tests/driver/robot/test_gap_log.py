"""Gaps: from the last good sample to the next good one, with the reason for which they began."""

from __future__ import annotations

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from omnimate.driver.robot.gap_log import GapLog

CHANNELS = ("a.left", "a.right")


def follow(presence, **events):
    log = GapLog(CHANNELS)
    for index, present in enumerate(presence):
        for name, (when, column) in events.items():
            if when == index:
                log.jumped(column) if name == "jumped" else log.restarted(column, float(index))
        log.close(present, float(index))
    return log


@given(st.lists(st.tuples(st.booleans(), st.booleans()), min_size=1, max_size=30))
def test_a_channel_is_absent_exactly_within_its_gaps(presence):
    """The samples strictly between start and end of a gap are those in which the channel is absent."""
    log = follow(presence)
    last = float(len(presence) - 1)
    for column, channel in enumerate(CHANNELS):
        gaps = [gap for gap in log.until(last) if gap.channel == channel]
        for index, present in enumerate(presence):
            inside = any(gap.start < index < gap.end for gap in gaps)
            at_an_edge = any(index in {gap.start, gap.end} for gap in gaps)
            assert not inside or not present[column]
            assert present[column] or inside or at_an_edge
        assert all(before.end <= after.start for before, after in pairwise(gaps))


def test_an_impossible_reading_makes_a_jump_and_a_restart_a_reboot():
    present = [(True, True), (False, True), (True, True)]
    assert [gap.reason for gap in follow(present).gaps] == ["missing"]
    assert [gap.reason for gap in follow(present, jumped=(1, 0)).gaps] == ["jump"]
    assert [gap.reason for gap in follow(present, restarted=(1, 0)).gaps] == ["reboot"]


def test_a_restart_within_a_gap_keeps_its_start():
    present = [(True, True), (False, True), (False, True), (True, True)]
    (gap,) = follow(present, restarted=(2, 0)).gaps
    assert (gap.start, gap.end, gap.reason) == (0.0, 3.0, "reboot")


def test_a_restart_between_two_good_samples_is_a_gap_too():
    (gap,) = follow([(True, True)] * 3, restarted=(2, 1)).gaps
    assert (gap.channel, gap.start, gap.end, gap.reason) == ("a.right", 1.0, 2.0, "reboot")
