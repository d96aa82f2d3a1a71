"""Formulas as text."""

import math
import re
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.effects.errors import ExpressionError
from omnimate.effects.expression import FUNCTIONS, MAX_DEPTH, parse

X = np.array([-1.5, 0.5, 2.0])
NUMBER = st.floats(0.0, 1e6).map(repr)
LEAF = NUMBER | st.just("x")


def nested(inner):
    binary = st.tuples(inner, st.sampled_from("+-*/"), inner).map(" ".join)
    name = st.sampled_from(["sin", "cos", "abs", "tanh"])
    one = st.tuples(name, inner).map(lambda pair: f"{pair[0]}({pair[1]})")
    return binary.map(lambda text: f"({text})") | binary | one | inner.map(lambda text: f"-{text}")


def python(text, x):
    """The formula as Python understands it."""
    names = {name: getattr(np, name) for name in FUNCTIONS if hasattr(np, name)}
    text = re.sub(r"\d+\.\d+(e[-+]\d+)?|\d+e[-+]\d+", lambda number: f"float64({number[0]})", text)
    with np.errstate(all="ignore"):
        return eval(text, {"x": x, "float64": np.float64, **names})  # a test's own text


@given(st.recursive(LEAF, nested, max_leaves=8))
def test_a_formula_has_the_value_that_python_gives_it(text):
    ours, theirs = parse(text).value({"x": X}), python(text, X)
    assert np.array_equal(ours, theirs, equal_nan=True)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("-2^2", -4.0),
        ("2^3^2", 512.0),
        ("2^-1", 0.5),
        ("8 - 3 - 2", 3.0),
        ("8 / 4 / 2", 1.0),
        ("--1", 1.0),
        ("2 * -3", -6.0),
        ("min(1, max(2, 3)) + .5e1", 6.0),
        (" sqrt ( log(exp(4)) ) ", 2.0),
        ("sign(-3) * tan(0)", -0.0),
    ],
)
def test_signs_powers_and_functions_bind_as_in_mathematics(text, value):
    assert parse(text).value({}) == pytest.approx(value)
    assert parse(text).variables == frozenset()


@pytest.mark.parametrize(
    ("text", "column", "expected"),
    [
        ("", 1, "'the end'; expected a number, a variable"),
        ("speed + * 3", 9, "expected a number, a variable, a function or"),
        ("2 speed", 3, "'speed'; expected an operator or the end"),
        ("sin speed", 5, "expected '\\('"),
        ("min(1)", 6, "'\\)'; expected ','"),
        ("abs(1, 2)", 6, "','; expected an operator or '\\)'"),
        ("(1 + 2", 7, "'the end'; expected an operator or '\\)'"),
        ("speed.real", 6, "'.'; expected"),
        ("x == 1", 3, "'='; expected"),
        ("1e999", 1, "expected a number below"),
        ("٣", 1, "expected"),
        ("__import__('os')", 11, "expected an operator or the end"),
    ],
)
def test_what_is_no_formula_is_refused_with_its_column_and_what_was_expected(text, column, expected):
    with pytest.raises(ExpressionError, match=f"column {column}: .*{expected}"):
        parse(text)


@given(st.text(alphabet="x1+-*/^(), .sinmae", max_size=40) | st.text(max_size=10))
def test_any_text_is_either_a_formula_or_refused(text):
    with suppress(ExpressionError):
        assert parse(text).steps


@pytest.mark.parametrize("deep", ["(" * 9999, "-" * 9999, "2^" * 9999, "sin(" * 9999])
def test_a_formula_that_is_too_deep_is_refused(deep):
    with pytest.raises(ExpressionError, match=f"expected at most {MAX_DEPTH}"):
        parse(deep)


def test_a_long_sum_is_no_deep_one():
    assert parse("+".join(["x"] * 5000)).value({"x": X}) == pytest.approx(5000.0 * X)


def test_where_there_is_no_value_it_is_not_finite_and_nothing_is_raised():
    values = parse("log(x) + 1 / (x - 0.5)").value({"x": X})
    assert not np.isfinite(values[:2]).any()
    assert math.isfinite(values[2])
