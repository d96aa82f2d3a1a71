"""Programs as tables."""

import math

import pytest

from omnimate.motion.program import (
    ARC,
    HERE,
    KEEP,
    LINE,
    PASS,
    REST,
    TURN,
    Program,
    ProgramError,
    Row,
    in_lap,
    rest,
)


def test_the_table_holds_every_column_of_every_row():
    rows = (Row(LINE, x=1.5, heading=math.pi, speed=0.2, lap=3), rest(2.0, fix=True))
    table = Program("free", rows, ("none",)).table
    assert len(table) == 2
    assert [tuple(row) for row in table] == [tuple(row) for row in rows]


def test_the_first_row_of_a_lap_alone_sets_its_frame():
    rows = in_lap(2, [Row(LINE), Row(LINE), Row(REST)], HERE)
    assert [row.lap for row in rows] == [2, 2, 2]
    assert [row.frame for row in rows] == [HERE, KEEP, KEEP]


@pytest.mark.parametrize(
    "row",
    [
        Row(LINE, x=1.0),
        Row(TURN, heading=math.nan, speed=0.2),
        Row(PASS, x=1.0, speed=0.3, corner_speed=0.1),
        Row(ARC, length=1.0, speed=0.3, curvature=0.0),
    ],
)
def test_a_row_that_could_not_be_finished_is_refused_with_its_number(row):
    with pytest.raises(ProgramError) as caught:
        Program("free", (rest(1.0), row), ())
    assert caught.value.row == 1


@pytest.mark.parametrize("side", [0.0, -1.0, math.nan])
def test_a_square_whose_side_is_not_above_zero_is_refused(side):
    with pytest.raises(ProgramError, match="expected more than 0"):
        Program("umbmark", (rest(1.0),), ("cw",), side)
