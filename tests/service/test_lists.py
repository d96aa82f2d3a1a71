"""Lists that are read page by page: every row once, newest first, whatever the size of the pages."""

from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.service.store.tables import DiagnosisRow, JobRow, read_page


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


def test_a_condition_leaves_rows_out(database):
    with database.writing() as db:
        db.query(JobRow).delete()
        db.add_all([job(0, 0), job(1, 1, "failed"), job(2, 2)])
    with database.reading() as db:
        rows, after = read_page(db, JobRow, 10, None, JobRow.state == "done")
    assert ([row.id for row in rows], after) == (["job2", "job0"], None)
