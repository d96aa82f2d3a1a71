"""From the linear search to the effects themselves: their parameters by Gauss-Newton."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects.effect import WHEEL
from omnimate.mismatch.candidates.nuisances import nuisances
from omnimate.mismatch.candidates.regression import Regression, slices_of
from omnimate.mismatch.candidates.terms import calibrated_terms
from omnimate.mismatch.evidence.density import MEMBER_SIZE
from omnimate.mismatch.evidence.rows import whiten_nuisances
from omnimate.mismatch.recording.response import data, relinearised, response
from omnimate.mismatch.recording.windows import windows_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from omnimate.effects.effect import Effect
    from omnimate.mismatch.candidates.terms import Term
    from omnimate.mismatch.noise.levels import NoiseLevels
    from omnimate.mismatch.recording.signals import Signals
    from omnimate.vehicle.se2 import Array

# Declared sizes by which the two wheels of an axle differ, half their difference: what is common to both (a
# tyre's load, a wrong figure in a data sheet) is larger. UMBmark's robot had a wheelbase 1.1 % off and
# diameters apart by 0.084 % (Borenstein & Feng, figure 11); OptiOdom publishes 1.7 % and 0.11 % of its robot.
UNEQUAL = 0.1
HELD = 1e12  # precision of a size that is known, far above that of any data
NEGLIGIBLE_SIZE = 1e-6  # [declared sizes] below which an effect is absent
TURNS = 2  # the effects are small, and the second turn changes them by their square


@dataclass(frozen=True, slots=True)
class Acting:
    """Effects as they fit best."""

    terms: tuple[Term, ...]  # one for each effect, with what is not linear as found
    values: tuple[Array, ...]  # coefficients of each term, `(k,)`
    effects: tuple[Effect, ...]  # the effects that these are
    places: tuple[slice, ...]  # of the terms' columns
    covariance: Array  # of all coefficients, `(K, K)`

    def covariances(self) -> list[Array]:
        """Return the covariance of each term's coefficients."""
        return [self.covariance[part, part] for part in slices_of(map(len, self.values))]


@dataclass(frozen=True, slots=True)
class Fitted:
    """A set of effects, and what is calibrated in any case, as they fit best."""

    regression: Regression  # about all of them, with the columns of their terms
    chosen: Acting  # the set
    calibrated: Acting  # what any recording with poses calibrates, unless it is in the set
    nuisance: Array  # whitened columns of what every robot has, each of one standard deviation, `(V, n)`

    @property
    def rows(self) -> Array:
        """Columns of the regression, the data first, with what every robot has being noise, `(V, C)`."""
        return whiten_nuisances(self.regression.white, self.nuisance)

    @property
    def mounted(self) -> tuple[Effect, ...]:
        """How references are mounted, which is no fault of the robot."""
        return tuple(effect for effect in self.calibrated.effects if effect.is_setup)

    @property
    def part(self) -> Array:
        """What of the data all effects explain, `(V,)`, whitened.

        It is what the effects do, and not their columns times their sizes: a column of a small step holds the
        noise of the readings it is made of, which, once added to the data, it would explain.
        """
        return np.asarray(self.data_about(()) - self.regression.white[:, 0])

    def data_about(self, effects: Sequence[Effect]) -> Array:
        """Return the whitened data (V,) about the robot with some effects."""
        raw = [data(windows, response(windows, effects)) for windows in self.regression.windows]
        return self.regression.whitened(raw)[:, 0]

    def linear_model(self, rows: Array) -> tuple[Array, Array]:
        """Return the columns (V, K) of everything in rows (V, C), and the data (V,) of the nominal robot."""
        columns = np.hstack([rows[:, :0], *(rows[:, place] for _, place, _ in self.everything())])
        known = np.concatenate([np.zeros(0), *(values for _, _, values in self.everything())])
        return columns, rows[:, 0] + columns @ known

    def squared_deviations(self) -> list[float]:
        """Return how far each effect's size is from zero, in squared standard deviations.

        They are those of the line from none of the effect to its size: a law with a threshold may be flat
        at its size itself.
        """
        columns, _ = self.linear_model(self.rows)
        prior = prior_of([*self.chosen.terms, *self.calibrated.terms], len(self.chosen.terms))
        covariance = np.linalg.inv(columns.T @ columns + prior)
        parts = zip(self.chosen.values, slices_of(map(len, self.chosen.values)), strict=True)
        return [float(size @ np.linalg.solve(covariance[part, part], size)) for size, part in parts]

    def everything(self) -> Iterator[tuple[Term, slice, Array]]:
        """Yield the terms of the set and of the calibration, their columns and their coefficients."""
        for acting in (self.chosen, self.calibrated):
            yield from zip(acting.terms, acting.places, acting.values, strict=True)


def fitted(
    signals: Sequence[Signals],
    noise: NoiseLevels,
    terms: Sequence[Term],
    values: Sequence[Array],
    turns: int = TURNS,
    start: Fitted | None = None,
    disturbances: Sequence[Array] | None = None,
) -> Fitted:
    """Return terms with their coefficients fitted, each turn about what the last one found.

    What every robot has is integrated out. The fit begins with `values`, and with the calibration of `start`;
    a step that leaves more than there was before it is halved.
    `disturbances` are process covariances (M, n, n) of each recording's disturbed windows.
    """
    count, keys = len(terms), {term.key for term in terms}
    all_terms = [term.fine() for term in terms]
    all_terms += [term for term in calibrated_terms(signals) if term.key not in keys]
    known = np.concatenate([np.zeros(0), *values, *(_begun(term, start) for term in all_terms[count:])])
    widths = [len(term.probes) for term in all_terms]
    parts = slices_of(widths)
    for term, part in zip(all_terms, parts, strict=True):
        known[part] = known[part] if term.held is None else term.held
    prior = prior_of(all_terms, count)
    held = held_of(all_terms)
    misfit, step = math.inf, np.zeros(len(known))
    for turn in range(turns + 1):
        effects = tuple(term.built(known[part]) for term, part in zip(all_terms, parts, strict=True))
        about = _regression_about(effects, signals, noise, start, disturbances)
        about_places = tuple(about.add(all_terms))
        if turn == 0:  # about any base they are the same, but for its square
            nuisance = about.whitened(nuisances(about.windows))
        rows = whiten_nuisances(about.white, nuisance)
        left = float(rows[:, 0] @ rows[:, 0] + known @ prior @ known)
        if left <= misfit:
            best, regression, places, misfit = known, about, about_places, left
            precision = rows[:, 1:].T @ rows[:, 1:] + prior
            step = np.linalg.solve(precision + held, rows[:, 1:].T @ rows[:, 0] - prior @ known)
        else:  # too far for a law that is not linear
            step = 0.5 * step
        known = best + step
        for term, part in zip(all_terms, parts, strict=True):
            if term.positive:
                known[part] = np.maximum(known[part], 0.0)
    values, width = tuple(best[part] for part in parts), sum(widths[:count])
    effects = tuple(regression.base)
    for place, effect, size in zip(places[:count], effects[:count], values[:count], strict=True):
        if len(size) == 1 and abs(size[0]) > NEGLIGIBLE_SIZE:
            regression.use_secant(place, effect, float(size[0]))
    covariance = np.linalg.inv(precision).astype(np.float64)

    def acting(which: slice, inside: slice) -> Acting:
        return Acting(
            tuple(all_terms[which]), values[which], effects[which], places[which], covariance[inside, inside]
        )

    chosen, calibrated = acting(slice(count), slice(width)), acting(slice(count, None), slice(width, None))
    return Fitted(regression, chosen, calibrated, nuisance)


def _regression_about(
    effects: tuple[Effect, ...],
    signals: Sequence[Signals],
    noise: NoiseLevels,
    start: Fitted | None,
    disturbances: Sequence[Array] | None,
) -> Regression:
    """Return the regression about some effects; other arguments are those of `fitted`."""
    if start is not None and start.regression.base == effects:
        trajectories = [model.signals for model in start.regression.windows]
    else:
        trajectories = [relinearised(nominal, effects) for nominal in signals]
    windows = [windows_of(trajectory) for trajectory in trajectories]
    if disturbances is not None:
        windows = [
            replace(model, rounding=model.rounding + disturbance)
            for model, disturbance in zip(windows, disturbances, strict=True)
        ]
    return Regression(windows, noise, effects)


def held_of(terms: Sequence[Term]) -> Array:
    """Return the precision (K, K) that holds coefficients whose size is known while the others are fitted."""
    return np.diag([HELD if term.held is not None else 0.0 for term in terms for _ in term.probes])


def prior_of(terms: Sequence[Term], count: int) -> Array:
    """Return the prior precision (K, K) of coefficients: of the first `count` terms, and of a calibration."""
    width = [len(term.probes) for term in terms]
    first = np.cumsum([0, *width])
    prior = np.eye(int(first[-1]))
    prior[: first[count], : first[count]] /= MEMBER_SIZE**2
    wheels = {
        term.component: number
        for number, term in enumerate(terms)
        if term.kind.calibrated and term.component in WHEEL
    }
    for wheel, left in wheels.items():
        truck, side = wheel.split(".")
        right = wheels.get(f"{truck}.right")
        if side == "left" and right is not None and max(left, right) >= count:
            common = MEMBER_SIZE if min(left, right) < count else 1.0
            pair = np.ix_([first[left], first[right]], [first[left], first[right]])
            alike, opposite = np.ones((2, 2)), np.array([[1.0, -1.0], [-1.0, 1.0]])
            prior[pair] = 0.25 * alike / common**2 + 0.25 * opposite / UNEQUAL**2
    return prior


def _begun(term: Term, start: Fitted | None) -> Array:
    """Return the coefficients of a term in a fit, or zeros where it is in none."""
    for other, _, values in start.everything() if start is not None else ():
        if other.key == term.key and len(values) == len(term.probes):
            return values
    return np.zeros(len(term.probes))
