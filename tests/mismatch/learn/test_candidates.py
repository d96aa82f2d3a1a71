"""Terms and curves: what they are made of, and that a curve is the process that it stands for."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.effects.expression import parse
from omnimate.mismatch.learn.candidates import SIZES, curves, terms
from omnimate.mismatch.learn.evidence import Products

VARIABLES = {
    "speed": np.linspace(-0.2, 0.8, 200),
    "time": np.linspace(0.1, 20.0, 200),
    "heading": np.linspace(0.0, 7.0, 200),
    "joint_a": np.linspace(-0.4, 0.5, 200),
    "acceleration": np.zeros(200),
}


def test_terms_are_formulas_of_unit_size_and_none_is_of_a_variable_that_stands_still():
    found = {text for term in terms(VARIABLES) for text in term.texts}
    assert not [text for text in found if "acceleration" in text]
    assert {"1", "speed^2", "speed * time", "abs(speed)", "joint_a", "heading"} <= found
    assert {"sin(heading)", "cos(4 * joint_a)"} <= found
    assert not {"abs(time)", "heading^2", "speed * heading"} & found
    for term in terms(VARIABLES):
        assert np.mean(term.basis**2, axis=0) == pytest.approx(1.0)
        for text, size, column in zip(term.texts, term.sizes, term.basis.T, strict=True):
            assert size * column == pytest.approx(parse(text).value(VARIABLES) * np.ones(200))


@pytest.mark.parametrize(("name", "lengths"), [("speed", (0.09, 0.15, 0.3)), ("heading", (0.25, 0.5, 1.0))])
def test_a_curve_has_the_covariance_of_a_squared_exponential_kernel(name, lengths):
    curve = next(curve for curve in curves(VARIABLES) if curve.variable == name)
    away = curve.knots[:, None] - curve.knots
    turns = math.tau * np.arange(-2, 3)[:, None, None] if curve.period else np.zeros((1, 1, 1))
    for number, spread in enumerate(curve.spreads):
        length, size = lengths[number // len(SIZES)], SIZES[number % len(SIZES)]
        if name == "speed":
            length *= np.ptp(curve.knots)  # half of the range is one
        covariance = (curve.at_knots * spread**2) @ curve.at_knots.T
        kernel = np.exp(-0.5 * ((away + turns) / length) ** 2).sum(axis=0)
        assert covariance / size**2 == pytest.approx(kernel, abs=0.06)


@settings(max_examples=30)
@given(st.integers(0, 10**6))
def test_the_evidence_is_the_density_of_the_rows_against_that_of_noise(seed):
    """Against the covariance of all rows, written out; folds left out one by one."""
    rng = np.random.default_rng(seed)
    columns, rows, folds = rng.standard_normal((30, 3)), rng.standard_normal(30), np.arange(30) // 10
    spread = rng.uniform(0.1, 2.0, 2)
    members = np.array([0, 2])

    def density(some):
        covariance = (columns[some][:, members] * spread**2) @ columns[some][:, members].T + np.eye(
            some.sum()
        )
        _, size = np.linalg.slogdet(covariance)
        return -0.5 * (rows[some] @ np.linalg.solve(covariance, rows[some]) + size - rows[some] @ rows[some])

    found = Products.of(columns, rows, folds).evidence(members[None], spread[None])[:, 0]
    parts = [np.full(30, fill_value=True), *(folds != fold for fold in range(3))]
    assert found == pytest.approx([density(some) for some in parts])
    left = Products.of(columns, rows, folds).without(1).evidence(members[None], spread[None])[0, 0]
    assert left == pytest.approx(found[2])
