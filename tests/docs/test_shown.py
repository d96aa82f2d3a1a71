"""The comparison of what is printed with what a page shows."""

import pytest

from tests.docs.shown import line_is, plain, same


@pytest.mark.parametrize(
    ("shown", "printed"),
    [
        ("E_b 0.98810 ± 0.00104 mm", "E_b   0.98811 ±  0.00103 mm"),
        ("residual 1.08 before, 0.98 after", "residual 1.07 before, 0.98 after"),
        ("written in ... s", "written in 3.2 s"),
        (" ──────── ", " ──────────── "),
    ],
)
def test_spaces_last_digits_and_what_is_left_open_may_differ(shown, printed):
    assert line_is(shown, printed)


@pytest.mark.parametrize(
    ("shown", "printed"),
    [
        ("wheelbase on a", "wheelbase on b"),
        ("residual 1.08 before", "residual 1.28 before"),
        ("5 laps", "6 laps"),
        ("a robot", "a robot, and more"),
    ],
)
def test_another_word_or_another_number_is_a_difference(shown, printed):
    assert not line_is(shown, printed)


def test_three_dots_on_a_line_stand_for_any_number_of_lines():
    assert same(("first", "...", "last"), ("first", "second", "third", "last"))
    assert same(("first", "...", "last"), ("first", "last"))
    assert not same(("first", "...", "last"), ("first", "second"))
    assert not same(("first",), ("first", "second"))


def test_control_sequences_and_lines_that_were_overwritten_are_not_output():
    assert plain("\x1b[31mred\x1b[0m \n working\rdone\n\n") == ["red", "done"]
