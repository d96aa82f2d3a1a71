"""The programs of the papers."""

import math

import pytest

from omnimate.motion.paths import (
    figure_eight,
    free,
    out_and_back,
    rounded_rectangle,
    squares,
    umbmark,
    via_points,
)
from omnimate.motion.program import ARC, GOTO, HERE, LINE, PASS, REST, TURN, WORLD


def lap_rows(program, lap):
    return [row for row in program.rows if row.lap == lap]


@pytest.mark.parametrize(("direction", "sign"), [("cw", -1), ("ccw", 1)])
def test_a_square_has_four_legs_with_stops_and_four_turns_of_which_the_last_is_at_home(direction, sign):
    rows = lap_rows(squares([direction], 4.0), 0)
    assert [row.kind for row in rows] == [LINE, REST, TURN, REST] * 4
    corners = [(row.x, row.y) for row in rows if row.kind == LINE]
    wanted = [(4.0, 0.0), (4.0, sign * 4.0), (0.0, sign * 4.0), (0.0, 0.0)]
    assert [pytest.approx(corner, abs=1e-9) for corner in wanted] == corners
    turns = [row.heading for row in rows if row.kind == TURN]
    assert turns == pytest.approx([sign * step * math.pi / 2.0 for step in (1, 2, 3, 4)])
    assert rows[0].frame == HERE


def test_umbmark_has_five_runs_in_each_direction_in_turn_or_grouped():
    assert umbmark().directions == ("cw", "ccw") * 5
    assert umbmark(order="grouped").directions == ("cw",) * 5 + ("ccw",) * 5
    assert umbmark().protocol == "umbmark"
    assert umbmark(side=3.0).side == 3.0


def test_every_lap_stands_between_rests_with_a_fix_and_later_ones_begin_at_home():
    program = umbmark(runs=2, link_length=1.0)
    between = [row for row in program.rows if row.lap < 0]
    kinds = [row.kind for row in between]
    assert kinds == [REST] + [REST, GOTO, GOTO, REST] * 3 + [REST]
    assert all(row.fix for row in between if row.kind == REST)
    homes = [row for row in between if row.kind == GOTO]
    assert all(row.truck == 0 for row in umbmark().rows), "a single truck has no second one"
    assert [(row.truck, row.x, row.frame) for row in homes] == [(0, 0.0, WORLD), (1, -1.0, WORLD)] * 3


def test_out_and_back_goes_back_in_reverse():
    there, _, back, _ = lap_rows(out_and_back(18.0, 3), 1)
    assert (there.x, there.reverse) == (18.0, 0)
    assert (back.x, back.heading, back.reverse) == (0.0, math.pi, 1)


def test_the_rectangle_passes_by_its_corners_and_comes_home_along_its_first_side():
    program = rounded_rectangle(7.0, 4.0, ["ccw", "cw"], tolerance=0.2)
    rows = lap_rows(program, 0)
    assert [row.kind for row in rows] == [PASS] * 4 + [LINE, REST]
    assert [(row.x, row.y) for row in rows[:4]] == [(3.5, 0.0), (3.5, 4.0), (-3.5, 4.0), (-3.5, 0.0)]
    assert {row.tolerance for row in rows[:4]} == {0.2}
    assert [row.y for row in lap_rows(program, 1)[:4]] == [0.0, -4.0, -4.0, 0.0]


def test_a_via_point_halves_the_speed_unless_told_otherwise():
    assert via_points([(1.0, 0.0)], 0.5, 0.3)[0].corner_speed == 0.15
    assert via_points([(1.0, 0.0)], 0.5, 0.3, 0.3)[0].corner_speed == 0.3


def test_a_free_drive_depends_on_its_seed_alone_and_stays_in_its_area():
    assert free(4) == free(4)
    assert free(4) != free(5)
    for row in free(4, area=(6.0, 4.0)).rows:
        if row.kind == PASS and row.x != -4.5:
            assert abs(row.x) <= 3.0
            assert abs(row.y) <= 2.0


def test_a_figure_of_eight_is_a_circle_to_the_left_and_one_to_the_right():
    left, right, _ = lap_rows(figure_eight(0.8), 0)
    assert (left.kind, right.kind) == (ARC, ARC)
    assert (left.y, left.curvature) == (0.8, 1.25)
    assert (right.y, right.curvature) == (-0.8, -1.25)
    assert left.length == pytest.approx(2.0 * math.pi * 0.8)
