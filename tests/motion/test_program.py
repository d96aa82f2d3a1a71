"""Programs as tables."""

import math

from motion.program import HERE, KEEP, LINE, REST, Program, Row, in_lap, rest


def test_the_table_holds_every_column_of_every_row():
    rows = (Row(LINE, x=1.5, heading=math.pi, speed=0.2, lap=3), rest(2.0, fix=True))
    table = Program("free", rows, ("none",)).table
    assert len(table) == 2
    assert [tuple(row) for row in table] == [tuple(row) for row in rows]


def test_a_rest_asks_for_a_fix_only_when_told():
    assert rest(1.0).fix == 0
    assert rest(1.0, fix=True) == Row(REST, duration=1.0, fix=1)


def test_the_first_row_of_a_lap_alone_sets_its_frame():
    rows = in_lap(2, [Row(LINE), Row(LINE), Row(REST)], HERE)
    assert [row.lap for row in rows] == [2, 2, 2]
    assert [row.frame for row in rows] == [HERE, KEEP, KEEP]
