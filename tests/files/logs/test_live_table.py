"""The live table: rates, jitter and changed bytes of each identifier, in bounded memory."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.files.logs import live_table
from omnimate.files.logs.frames import EXTENDED, Frame
from omnimate.files.logs.live_table import CHANGE_TIME, RATE_FRAMES, LiveTable
from tests.files.logs.any_frames import logs


def table_of(rows):
    """A table that has heard frames at their times."""
    table = LiveTable()
    for row in rows:
        table.take(row, row.time)
    return table


@given(st.lists(st.integers(1, 10**5), min_size=2, max_size=RATE_FRAMES - 1))
def test_rate_and_jitter_are_those_of_the_intervals(steps):
    times = np.cumsum(steps) * 1e-6
    (row,) = table_of(Frame(time, 0x181, b"a") for time in times.tolist()).rows(times[-1])
    intervals = np.diff(times)
    assert row.rate == pytest.approx(1.0 / intervals.mean())
    assert row.jitter == pytest.approx(intervals.std(), abs=1e-12)
    assert row.frames == len(steps)


def test_an_identifier_that_is_away_has_no_rate_but_an_age():
    rows = [Frame(0.1 * number, 0x181) for number in range(10)]
    (row,) = table_of(rows).rows(0.9 + 1.1)
    assert (row.rate, row.age) == (0.0, pytest.approx(1.1))


def test_a_pause_lowers_no_rate():
    times = [0.1 * number for number in range(10)] + [60.0 + 0.1 * number for number in range(10)]
    (row,) = table_of(Frame(time, 0x181) for time in times).rows(60.9)
    assert row.rate == pytest.approx(10.0)
    assert row.jitter == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("before", [2e-4, 0.1], ids=["a burst", "a faster heartbeat"])
def test_a_heartbeat_that_becomes_slower_has_the_new_rate_and_is_not_away(before):
    times = [before * number for number in range(50)] + [10.0 + 3.0 * number for number in range(4)]
    (row,) = table_of(Frame(time, 0x703) for time in times).rows(times[-1] + 2.5)
    assert row.rate == pytest.approx(1 / 3, rel=0.4)
    (row,) = table_of(Frame(time, 0x703) for time in times).rows(times[-1] + 300.0)
    assert row.rate == 0.0


def test_a_byte_counts_as_changed_for_a_second():
    table = table_of([Frame(0.0, 0x181, b"\1\2"), Frame(0.5, 0x181, b"\1\3")])
    assert table.rows(0.5)[0].changed == (False, True)
    assert table.rows(0.5 + CHANGE_TIME + 0.01)[0].changed == (False, False)


def test_all_bytes_of_another_length_are_changed():
    table = table_of([Frame(0.0, 0x181, b"\1\2"), Frame(0.5, 0x181, b"\1\2\3")])
    assert table.rows(0.5)[0].changed == (True, True, True)


def test_width_and_kind_of_an_identifier_keep_rows_apart_in_their_order():
    rows = table_of([Frame(0.0, 0x181, b"", EXTENDED), Frame(0.0, 0x181), Frame(0.0, 0x080)]).rows(0.0)
    assert [(row.frame.can_id, row.frame.flags) for row in rows] == [
        (0x080, 0),
        (0x181, 0),
        (0x181, EXTENDED),
    ]


def test_what_is_beyond_the_largest_number_of_identifiers_is_counted(monkeypatch):
    monkeypatch.setattr(live_table, "MAX_IDENTIFIERS", 3)
    table = table_of(Frame(0.0, can_id) for can_id in (1, 2, 3, 4, 5, 1))
    assert (len(table.rows(0.0)), table.frames, table.others) == (3, 6, 2)


@given(logs())
def test_no_frame_is_lost_whatever_its_kind(rows):
    table = table_of(rows)
    assert sum(row.frames for row in table.rows(rows[-1].time)) == len(rows)
