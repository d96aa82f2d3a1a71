"""Maximum-likelihood estimation of a calibration: Gauss-Newton on whitened residuals.

Every pass of the filter gives the residuals and their derivatives. The noise's variances follow from the
same pass by restricted maximum likelihood: what a variance explains of the residuals, against what it should
explain given the fitted parameters; the ratio is 1 at the maximum. Fixes that lie too far from what all the
others say get a weight of the square of (threshold / distance), so that a wild one loses its influence and
good ones keep all of theirs.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import chi2

from calib.errors import CalibrationError, UnobservableError
from calib.estimates import DownWeighted, Estimate, NoiseEstimate
from calib.observability import Held, information_bound, unobservable
from calib.residuals import Residuals

if TYPE_CHECKING:
    from collections.abc import Collection

    from calib.chains import Chains, Problem
    from calib.filtering import Filtered
    from vehicle.se2 import Array

_ROBUST_ROUNDS = 7  # rounds in which variances come from medians, which no outlier can move
_FIRST_WEIGHTS = 3  # of them, in which only the weights follow, so that an outlier is not taken for noise
_MOST_ROUNDS = 60
_STILL = 5e-3  # standard deviations by which coordinates still move when all is done
_SETTLED = 0.1  # change of a weight, or of a variance in its standard deviations, likewise
_PATIENCE = 25  # rounds after which a noise that hardly matters, and so creeps, is not waited for
_SLOW = 3e-2  # standard deviations by which coordinates may then still move
_HASTE = 1.5  # power of the factors, until one overshoots: variances that tell little converge slowly
_CALM = 0.3  # that power when patience is at its end
_LEAST = 1e-6  # of the guess: a smaller variance is none
_GROWTH = 0.05  # of the logarithm of a variance, to see how the rest changes
_LINEAR = 0.03  # standard deviations by which coordinates may move before the chains are built anew
_DOUBTFUL = 1e-3  # a good fix lies beyond the threshold with this probability
_THRESHOLD = np.concatenate(([np.inf], chi2.isf(_DOUBTFUL, [1, 2, 3])))  # by known components
_NAMED = 0.5  # a fix with a smaller weight is reported
_MEDIAN = 0.6  # of a chi-square per degree of freedom, for one to three of them
_FEWEST = 2.0  # degrees of freedom from which a variance is estimated


def estimate(problem: Problem, hold: Collection[str] = (), known: Array | None = None) -> Estimate:
    """Return the estimate of a problem.

    Args:
        problem: with its data.
        hold: names of coordinates that stay nominal.
        known: (P, P) information on the coordinates from elsewhere, about nominal; None for none.

    Raises:
        UnobservableError: the data tell nothing about any coordinate.
        CalibrationError: the fit does not converge.
    """
    search = _Search(problem, hold, known)
    search.run(_ROBUST_ROUNDS)
    held = [Held(name, "held by request", float("nan")) for name in hold]
    while True:
        found = unobservable(problem.coordinates, search.information, search.free)
        lost = {one.name: one.reason for one in found}
        search.free = search.free & np.array([one.name not in lost for one in problem.coordinates])
        held += found
        if not search.free.any():
            raise UnobservableError(problem.source, {one.name: one.reason for one in held})
        if not found and not search.prior.any():
            break
        search.release()
        search.run(0)
    return search.result(tuple(held))


class _Search:
    """Coordinates, variances and weights on their way to the maximum of the likelihood."""

    def __init__(self, problem: Problem, hold: Collection[str], known: Array | None) -> None:
        unknown = set(hold) - {one.name for one in problem.coordinates}
        if unknown:
            names = ", ".join(one.name for one in problem.coordinates)
            raise CalibrationError(
                problem.source, f"cannot hold {', '.join(unknown)}; expected one of {names}"
            )
        self.problem = problem
        self.free = np.array([one.name not in hold for one in problem.coordinates])
        self.coordinates = self.origin = np.zeros(len(self.free))
        self.built: Chains | None = None
        self.variances = np.array([one.guess**2 for one in problem.noises])
        self.expected = np.zeros(len(self.variances))
        self.growth = np.zeros(len(self.variances))
        self.haste = np.full(len(self.variances), _HASTE)
        self.information = np.zeros((len(self.free), len(self.free)))
        self.known = self.information if known is None else known
        self.prior = np.array([one.doubt**-2.0 for one in problem.coordinates])
        self.weights = np.ones(0)
        self.distance = np.ones(0)
        self.rms = float("nan")

    def release(self) -> None:
        """Put held coordinates back to nominal, and forget what was known of the others without a drive."""
        self.prior = np.zeros_like(self.prior)
        self.coordinates = np.where(self.free, self.coordinates, 0.0)

    def run(self, robust_rounds: int) -> None:
        """Iterate to convergence, the first rounds with variances that no outlier can move.

        Raises:
            CalibrationError: it does not converge.
        """
        for number in range(_MOST_ROUNDS):
            self.haste = np.minimum(self.haste, _HASTE if number < _PATIENCE else _CALM)
            moved, settled = self._round(number, robust=number < robust_rounds)
            enough = settled or number > _PATIENCE
            if number >= robust_rounds and enough and moved < (_STILL if settled else _SLOW):
                return
        raise CalibrationError(
            self.problem.source,
            "the least-squares fit does not converge; check that wheels and poses belong to the same drive, "
            "their units, and which wheel is left",
        )

    def _round(self, number: int, *, robust: bool) -> tuple[float, bool]:
        """Do one pass; return by how many sigma the coordinates moved, and whether the noise is settled."""
        chains = self._chains()
        filtered, smoothed = chains.filtered(self.variances, self.weights)
        slope = filtered.innovation[:, :, 1:]
        value = filtered.innovation[:, :, 0] + slope @ (self.coordinates - self.origin)
        white = filtered.precision @ slope
        self.information = np.tensordot(slope, white, ((0, 1), (0, 1))) + self.known
        gradient = np.tensordot(white, value, ((0, 1), (0, 1))) + self.known @ self.coordinates
        bound = information_bound(self.information + np.diag(self.prior), self.free)
        change = -bound @ (gradient + self.prior * self.coordinates)
        change *= min(1.0, 0.3 / max(float(np.abs(change).max()), 1e-12))
        self.coordinates = self.coordinates + change
        moved = float(np.sqrt(change @ self.information @ change))
        self._measure(chains, filtered, value + slope @ change)
        now = Residuals(chains, filtered.heading, smoothed, self.coordinates - self.origin, bound)
        grown = self._scale(now, robust=robust) if number >= _FIRST_WEIGHTS or not robust else 1.0
        weighed = self._weigh(now)
        return moved, grown < _SETTLED and weighed < _SETTLED

    def _chains(self) -> Chains:
        """Return the chains, anew where the coordinates have left the point at which they are linear."""
        away = self.coordinates - self.origin
        if self.built is None or float(np.sqrt(away @ self.information @ away)) > _LINEAR:
            self.built = self.problem.chains(self.coordinates)
            self.origin = self.coordinates
            if len(self.weights) == 0:
                self.weights, self.distance = np.ones(len(self.built.first)), np.zeros(len(self.built.first))
        return self.built

    def _measure(self, chains: Chains, filtered: Filtered, residual: Array) -> None:
        known = np.isfinite(chains.measured).sum() - 3 * chains.first.sum()
        square = float(np.einsum("ki,kij,kj->", residual, filtered.precision, residual))
        self.rms = float(np.sqrt(square / max(known - self.free.sum(), 1)))

    def _scale(self, now: Residuals, *, robust: bool) -> float:
        """Scale the variances towards their likeliest values; return by how much at most."""
        largest = 0.0
        for number in range(len(self.variances)):
            found, expected = now.explained(number, self.variances[number], self.weights)
            self.expected[number] = expected.sum()
            if self.expected[number] < _FEWEST:
                continue
            if robust:
                some = expected > 1e-9 * expected.max()
                ratio = float(np.median(found[some] / expected[some])) / _MEDIAN
            else:
                ratio = float(found.sum() / self.expected[number])
            growth = math.log(min(max(ratio, 0.02), 50.0))
            overshot = growth * self.growth[number] < 0.0
            self.haste[number] = max(0.5 * self.haste[number], 0.2) if overshot else self.haste[number]
            self.growth[number] = growth
            least = _LEAST * self.problem.noises[number].guess ** 2
            if growth < 0.0 and self.variances[number] <= least:
                continue  # data without this noise, as simulations have
            self.variances[number] = max(
                self.variances[number] * math.exp(growth * self.haste[number]), least
            )
            largest = max(largest, abs(growth) * math.sqrt(self.expected[number]))
        return largest

    def _weigh(self, now: Residuals) -> float:
        """Weigh every fix by how far it lies from what all others say; return the largest change."""
        square = now.distances(self.variances, self.weights)
        components = np.isfinite(now.chains.measured).sum(axis=1)
        weights = np.minimum(1.0, _THRESHOLD[components] / np.maximum(square, 1e-12))
        moved = float(np.abs(weights - self.weights).max(initial=0.0))
        self.weights, self.distance = np.sqrt(weights * self.weights), np.sqrt(square)
        return moved

    def _freedom(self, number: int, covariance: Array) -> tuple[float, float]:
        """Return the degrees of freedom of a variance's estimate, and what hangs on it.

        The first is twice the information on its logarithm: what it is expected to explain, tr(V^-1 V_j),
        falls when it grows; how fast is the information. The second is the largest change of the logarithm
        of a coordinate's variance by its own.
        """
        if self.expected[number] < _FEWEST:
            return 0.0, 0.0
        grown = self.variances.copy()
        grown[number] *= math.exp(_GROWTH)
        chains = self._chains()
        filtered, smoothed = chains.filtered(grown, self.weights)
        slope = filtered.innovation[:, :, 1:]
        information = np.tensordot(slope, filtered.precision @ slope, ((0, 1), (0, 1))) + self.known
        bound = information_bound(information, self.free)
        now = Residuals(chains, filtered.heading, smoothed, self.coordinates - self.origin, bound)
        _, expected = now.explained(number, grown[number], self.weights)
        # explained by V_j grown: with its variance as it was, the growth of the factor itself is taken out
        slope_of_rest = (float(expected.sum()) * math.exp(-_GROWTH) - self.expected[number]) / _GROWTH
        before, after = np.diag(covariance)[self.free], np.diag(bound)[self.free]
        return float(max(-slope_of_rest, 0.0)), float(np.abs(np.log(after / before)).max()) / _GROWTH

    def result(self, held: tuple[Held, ...]) -> Estimate:
        """Return the estimate."""
        problem = self.problem
        covariance = information_bound(self.information, self.free)
        known = [self._freedom(number, covariance) for number in range(len(self.variances))]
        # Satterthwaite (1946): variances add, each by what hangs on it
        doubtful = sum(hangs**2 / own for own, hangs in known if own > 0.0)
        doubts = np.array([one.doubt for one in problem.coordinates])[self.free]
        scaled = self.information[np.ix_(self.free, self.free)] * np.outer(doubts, doubts)
        worst = [int(k) for k in np.argsort(self.weights) if self.weights[k] < _NAMED]
        return Estimate(
            problem.coordinates,
            np.where(self.free, self.coordinates, 0.0),
            covariance,
            held,
            float(np.linalg.cond(scaled)),
            tuple(
                NoiseEstimate(noise, float(np.sqrt(variance)), float(own))
                for noise, variance, (own, _) in zip(problem.noises, self.variances, known, strict=True)
            ),
            1.0 / max(doubtful, 1e-6),
            tuple(
                DownWeighted(*problem.place(k), float(self.distance[k]), float(self.weights[k]))
                for k in worst
            ),
            len(self.weights),
            self.rms,
        )
