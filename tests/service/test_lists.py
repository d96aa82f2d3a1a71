"""Lists that are read page by page: every row once, newest first, whatever the size of the pages."""

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.service.errors import InvalidValueError
from omnimate.service.store.tables import CURSOR_PATTERN, DiagnosisRow, JobRow, read_page


def job(number, created, state="done"):
    return DiagnosisRow(
        id=f"job{number}", recordings=[], state=state, progress=1.0, doing="", attempts=1,
        created=float(created), changed=float(created),
    )  # fmt: skip


@settings(max_examples=40)
@given(ages=st.lists(st.integers(0, 3), max_size=12), limit=st.integers(1, 5))
def test_the_pages_hold_every_row_once_newest_first_even_where_ages_are_equal(database, ages, limit):
    with database.writing() as db:
        db.query(JobRow).delete()
        db.add_all(job(number, age) for number, age in enumerate(ages))
    listed, after = [], None
    with database.reading() as db:
        while True:
            rows, after = read_page(db, JobRow, limit, after)
            assert len(rows) <= limit
            listed += [(row.created, row.id) for row in rows]
            if after is None:
                break
    assert listed == sorted(((float(age), f"job{n}") for n, age in enumerate(ages)), reverse=True)


@settings(max_examples=40)
@given(
    ages=st.lists(st.integers(0, 3), min_size=1, max_size=12),
    limit=st.integers(1, 5),
    deleted=st.sets(st.integers(0, 11)),
)
def test_the_next_page_is_the_same_when_rows_before_it_are_deleted(database, ages, limit, deleted):
    with database.writing() as db:
        db.query(JobRow).delete()
        db.add_all(job(number, age / 3) for number, age in enumerate(ages))
        first, after = read_page(db, JobRow, limit, None)
        if after is None:
            return
        expected = [row.id for row in read_page(db, JobRow, limit, after)[0]]
        for row in (row for number, row in enumerate(first) if number in deleted):
            db.delete(row)
        db.flush()
        assert [row.id for row in read_page(db, JobRow, limit, after)[0]] == expected


@given(
    created=st.floats(0.0, 1e11),
    identity=st.from_regex(r"[0-9a-f]{16}|msg_[0-9a-f]{24}|A[A-Za-z._-]*", fullmatch=True),
)
def test_every_cursor_is_of_the_form_that_is_asked_for(created, identity):
    assert re.fullmatch(CURSOR_PATTERN, f"{created!r}_{identity[:64]}")


@pytest.mark.parametrize("after", ["", "none", "1.0", "_a", "1.0_", "1.0_a\x00", "nan_a", "1.0_a\n"])
def test_what_is_no_cursor_is_refused(database, after):
    with database.reading() as db, pytest.raises(InvalidValueError, match="expected the `next`"):
        read_page(db, JobRow, 10, after)


def test_a_condition_leaves_rows_out(database):
    with database.writing() as db:
        db.query(JobRow).delete()
        db.add_all([job(0, 0), job(1, 1, "failed"), job(2, 2)])
    with database.reading() as db:
        rows, after = read_page(db, JobRow, 10, None, JobRow.state == "done")
    assert ([row.id for row in rows], after) == (["job2", "job0"], None)
