"""Candidates for a law: terms of a formula, and curves over one variable, as columns with a prior.

A curve is a Gaussian process with a squared-exponential kernel, as a linear model: of sines on a domain wider
than the data (Solin and Särkkä, Hilbert space methods for reduced-rank Gaussian process regression,
Statistics and Computing 30, 2020), or of harmonics of a periodic angle. Every variable enters in units of
its root mean square in the drive, so that the result does not depend on the unit in which it is stated.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects.expression import parse
from omnimate.effects.variables import VARIABLES, WHEEL_ANGLE
from omnimate.mismatch.candidates.quantities import RARE

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from omnimate.vehicle.se2 import Array

SIZES = np.array([0.25, 1.0, 4.0, 16.0])  # [a-priori sizes] of a law: that size is an order of magnitude
MAX_ORDER = 4  # highest harmonic of an angle in a formula
MAX_WHEEL_ORDER = 40  # highest harmonic of a wheel's angle: gears and belts
# Lengths of curves in half ranges of their variable. The domain is twice as wide as the data (3.2 times the
# longest length), and has 20 sines (1.75 times its width over the shortest length), as asked for in
# Riutort-Mayol et al., Practical Hilbert space approximate Bayesian Gaussian processes, Statistics and
# Computing 33, 2023, for this kernel.
LENGTHS = (0.18, 0.3, 0.6)
DOMAIN, SINES = 2.0, 20
FREQUENCIES = 0.5 * math.pi / DOMAIN * np.arange(1.0, SINES + 1.0)
# Lengths of curves over a turn [rad]; the harmonics above the eighth have under 4 % of its variance.
TURN_LENGTHS = (0.25, 0.5, 1.0)
HARMONICS = np.arange(9)
KNOTS = 40  # of the exported curve; linear interpolation between them misses under 1 % of its variance
MOMENTS = 160  # of a drive, at which an error may begin
COARSE, MAX_LENGTH = 4, 8  # an error may last from every fourth of them to one of the next eight of these


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Candidate:
    """Columns that enter a law together."""

    kind: str  # kind of candidate: a constant, a line and so on. All kinds have the same prior probability
    basis: Array  # columns, shape `(N, b)`
    # prior standard deviations of the columns' coefficients, in a-priori sizes of the law: one row for each
    # hyperparameter from which the evidence chooses, shape `(h, b)`
    spreads: Array


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Term(Candidate):
    """Summands of a formula that enter it together."""

    texts: tuple[str, ...]  # what the coefficient of each column multiplies
    sizes: Array  # root mean square of each over the drive, by which its column is divided, shape `(b,)`


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Curve(Candidate):
    """A smooth curve over one variable."""

    variable: str  # name of the variable
    period: float  # period in the variable's unit; 0 for none
    knots: Array  # values of the variable at which the curve is exported, shape `(k,)`
    at_knots: Array  # columns at these values, shape `(k, b)`


def terms(variables: Mapping[str, Array]) -> Iterator[Term]:
    """Yield the terms that a formula may have, of variables with names of `VARIABLES` and values `(N,)`."""
    shape = next(iter(variables.values())).shape
    moving = {name: values for name, values in variables.items() if np.ptp(values) > 0.0}
    for kind, *texts in _texts(moving):
        columns = [np.broadcast_to(parse(text).value(variables), shape) for text in texts]
        basis = np.stack(columns, axis=1)
        sizes = np.sqrt(np.mean(basis**2, axis=0))
        spreads = SIZES[:, None] * np.ones(len(texts))
        yield Term(kind=kind, basis=basis / sizes, spreads=spreads, texts=tuple(texts), sizes=sizes)


def _texts(variables: Mapping[str, Array]) -> Iterator[tuple[str, ...]]:
    """Yield the kind of each term and what its coefficients multiply."""
    yield "constant", "1"
    for name in variables:
        yield "line", name
    plain = [name for name, values in variables.items() if not _is_periodic(name, values)]
    for name in plain:
        values = variables[name]
        yield "bent", f"{name}^2"
        yield "bent", f"1 / (1 + abs({name}) / {math.sqrt(np.mean(values**2)):.6g})"
        if values.min() < 0.0 < values.max():
            yield "bent", f"abs({name})"
            yield "bent", f"sign({name})"
    for first, second in itertools.combinations(plain, 2):
        yield "product", f"{first} * {second}"
    if "time" in plain:
        yield from _stretches(variables["time"])
    for name in variables:
        if VARIABLES[name].unit == "rad":
            for order in range(1, 1 + (MAX_WHEEL_ORDER if name == WHEEL_ANGLE else MAX_ORDER)):
                angle = name if order == 1 else f"{order} * {name}"
                yield "wave", f"sin({angle})", f"cos({angle})"


def _stretches(time: Array) -> Iterator[tuple[str, str]]:
    """Yield errors that begin at a moment, and those that last from one moment to another."""
    moments = [f"sign(time - {at:.6g})" for at in np.linspace(time.min(), time.max(), MOMENTS + 2)[1:-1]]
    for start in moments:
        yield "step", start
    coarse = moments[::COARSE]
    for first, start in enumerate(coarse):
        for end in coarse[first + 1 : first + 1 + MAX_LENGTH]:
            yield "stretch", f"({start} - {end})"


def curves(variables: Mapping[str, Array]) -> Iterator[Curve]:
    """Yield a curve over each variable that varies; for the arguments see `terms`."""
    for name, values in variables.items():
        low, high = np.quantile(values, [RARE, 1.0 - RARE])
        if _is_periodic(name, values):
            # the Fourier series of a kernel that is wrapped round has its spectral density
            orders = np.concatenate([HARMONICS, HARMONICS[1:]])
            spreads = _spreads(TURN_LENGTHS, orders, np.where(orders > 0, 1.0, 0.5) / math.pi)
            knots, period = np.arange(KNOTS) * math.tau / KNOTS, math.tau
            columns, at_knots = _harmonics(values), _harmonics(knots)
        elif high > low:
            middle, half = 0.5 * (low + high), 0.5 * (high - low)
            at = np.linspace(-1.0, 1.0, KNOTS)
            within = np.clip((values - middle) / half, -1.0, 1.0)
            spreads = _spreads(LENGTHS, FREQUENCIES, np.ones(SINES))
            knots, period = middle + half * at, 0.0
            columns, at_knots = _sines(within), _sines(at)
        else:
            continue
        yield Curve(
            kind="curve",
            basis=columns,
            spreads=spreads,
            variable=name,
            period=period,
            knots=knots,
            at_knots=at_knots,
        )


def _is_periodic(name: str, values: Array) -> bool:
    """Say whether a variable is an angle that turns a full circle in the drive."""
    return VARIABLES[name].unit == "rad" and float(np.ptp(values)) >= math.tau


def _sines(place: Array) -> Array:
    """Return the eigenfunctions `(N, b)` of the Laplace operator on the domain at places from -1 to 1."""
    return np.asarray(np.sin((place[:, None] + DOMAIN) * FREQUENCIES) / math.sqrt(DOMAIN))


def _harmonics(angle: Array) -> Array:
    """Return 1 and cosines and sines of multiples of angles [rad], `(N, b)`."""
    phase = angle[:, None] * HARMONICS
    return np.concatenate([np.cos(phase), np.sin(phase[:, 1:])], axis=1)


def _spreads(lengths: tuple[float, ...], frequency: Array, weight: Array) -> Array:
    """Return spreads `(h, b)`: roots of the squared-exponential kernel's spectral density, for every size."""
    density = [math.sqrt(math.tau) * length * np.exp(-0.5 * (frequency * length) ** 2) for length in lengths]
    return np.vstack([SIZES[:, None] * np.sqrt(weight * of_length) for of_length in density])
