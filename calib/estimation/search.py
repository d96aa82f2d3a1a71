"""Maximum-likelihood estimation of a calibration: Gauss-Newton on whitened residuals.

Every pass of the filter gives the residuals and their derivatives. The variances of the noise follow from the
same pass by restricted maximum likelihood: the part of the residuals that a variance explains is divided by
its expectation for the fitted parameters; the ratio is 1 at the maximum. Fixes too far from the prediction by
all others get the weight (threshold / distance)^2, so that an outlier loses its influence and good fixes keep
all of theirs.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.errors import CalibrationError, UnobservableError
from omnimate.calib.estimation.estimates import DownWeighted, Estimate, NoiseLevel
from omnimate.calib.estimation.observability import Held, information_bound, unobservable
from omnimate.calib.estimation.residuals import Residuals, outlier_weights

if TYPE_CHECKING:
    from collections.abc import Collection

    from omnimate.calib.estimation.chains import Chains, Problem
    from omnimate.calib.estimation.filtering import Filtered
    from omnimate.vehicle.se2 import Array

_ROBUST_ROUNDS = 7  # rounds in which variances come from medians, which outliers do not change
_FIRST_WEIGHTS = 3  # first rounds, in which only weights change: no outlier is then taken for noise
_MOST_ROUNDS = 120  # the slowest half of a public set (OptiOdom) needs 70
_CONVERGED = 5e-3  # [standard deviations] largest last change of the coordinates
_SETTLED = 0.1  # largest last change of a weight, or of a variance in its standard deviations
_PATIENT_ROUNDS = 25  # rounds in which the variances must settle; then a slow, unimportant one is ignored
_NEARLY_CONVERGED = 3e-2  # [standard deviations] largest last change of the coordinates after these rounds
_FAST_POWER = 1.5  # power of the factors until one overshoots: badly known variances converge slowly
_SLOW_POWER = 0.3  # power of the factors after the patient rounds
_LEAST = 1e-6  # [guess] a smaller variance counts as zero
_GROWTH = 0.05  # step of the logarithm of a variance for its numerical derivative
_LINEAR = 0.03  # [standard deviations] change of the coordinates after which the chains are rebuilt
_NAMED = 0.5  # a fix with a smaller weight is reported
_CHECK = "check that wheels and poses belong to the same drive, their units, and which wheel is left"
_MEDIAN = 0.6  # median of a chi-square per degree of freedom, for one to three degrees
_FEWEST = 2.0  # degrees of freedom from which on a variance is estimated


def estimate(problem: Problem, hold: Collection[str] = (), known: Array | None = None) -> Estimate:
    """Return the estimate of a problem.

    Coordinates whose names are in `hold` stay nominal. `known` is information on the coordinates from other
    sources, about nominal, shape `(P, P)`; None for none.

    Raises:
        UnobservableError: The data identify none of the coordinates.
        CalibrationError: The fit does not converge, most fixes contradict it, or `hold` names an unknown
            coordinate.
    """
    search = _Search(problem, hold, known)
    search.run(_ROBUST_ROUNDS)
    held = [Held(name, "held by request", float("nan")) for name in hold]
    while True:
        newly_held, search.free = unobservable(problem.coordinates, search.information, search.free)
        held += newly_held
        if not search.free.any():
            raise UnobservableError(
                problem.source, {coordinate.name: coordinate.reason for coordinate in held}
            )
        if not newly_held and not search.prior.any():
            break
        search.release()
        search.run(0)
    return search.result(tuple(held))


class _Search:
    """The search for the coordinates, variances and weights of the maximum likelihood."""

    def __init__(self, problem: Problem, hold: Collection[str], known: Array | None) -> None:
        known_names = [coordinate.name for coordinate in problem.coordinates]
        unknown = set(hold) - set(known_names)
        if unknown:
            names = ", ".join(known_names)
            raise CalibrationError(
                problem.source, f"cannot hold {', '.join(unknown)}; expected one of {names}"
            )
        self.problem = problem
        self.free = np.array([name not in hold for name in known_names])
        self.coordinates = self.origin = np.zeros(len(self.free))
        self.built: Chains | None = None
        self.variances = np.array([noise.guess**2 for noise in problem.noises])
        self.expected = np.zeros(len(self.variances))
        self.growth = np.zeros(len(self.variances))
        self.power = np.full(len(self.variances), _FAST_POWER)
        self.information = np.zeros((len(self.free), len(self.free)))
        self.known = self.information if known is None else known
        self.prior = np.array([coordinate.prior_sigma**-2.0 for coordinate in problem.coordinates])
        self.weights = np.ones(0)
        self.distance = np.ones(0)
        self.rms = float("nan")

    def release(self) -> None:
        """Put held coordinates back to nominal, and leave out the prior knowledge of the others."""
        self.prior = np.zeros_like(self.prior)
        self.coordinates = np.where(self.free, self.coordinates, 0.0)

    def run(self, robust_rounds: int) -> None:
        """Iterate to convergence; in the first rounds the variances come from medians.

        Raises:
            CalibrationError: The fit does not converge, or most fixes contradict it.
        """
        for number in range(_MOST_ROUNDS):
            self.power = np.minimum(self.power, _FAST_POWER if number < _PATIENT_ROUNDS else _SLOW_POWER)
            moved, settled = self._round(number, robust=number < robust_rounds)
            enough = settled or number > _PATIENT_ROUNDS
            if number >= robust_rounds and enough and moved < (_CONVERGED if settled else _NEARLY_CONVERGED):
                self._check_majority()
                return
        raise CalibrationError(self.problem.source, f"the least-squares fit does not converge; {_CHECK}")

    def _check_majority(self) -> None:
        """Refuse a fit that more than half of the fixes contradict.

        Raises:
            CalibrationError: It is such a fit; its good fixes may as well be the outliers.
        """
        outliers, fixes = int((self.weights < _NAMED).sum()), len(self.weights)
        if 2 * outliers > fixes:
            problem = f"{outliers} of {fixes} absolute poses do not fit the wheels; {_CHECK}"
            raise CalibrationError(self.problem.source, problem)

    def _round(self, number: int, *, robust: bool) -> tuple[float, bool]:
        """Do a pass; return the coordinates' change [standard deviations], and whether the noise settled."""
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
        square = now.distances(self.variances, self.weights)  # before the variances change
        grown = self._scale(now, robust=robust) if number >= _FIRST_WEIGHTS or not robust else 1.0
        weighed = self._weigh(chains, square)
        return moved, grown < _SETTLED and weighed < _SETTLED

    def _chains(self) -> Chains:
        """Return the chains, rebuilt where the coordinates have left their linear range."""
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
        """Scale the variances towards their likeliest values; return the largest change."""
        largest = 0.0
        for number in range(len(self.variances)):
            explained, expected = now.explained(number, self.variances[number], self.weights)
            self.expected[number] = expected.sum()
            if self.expected[number] < _FEWEST:
                continue
            if robust:
                some = expected > 1e-9 * expected.max()
                ratio = float(np.median(explained[some] / expected[some])) / _MEDIAN
            else:
                ratio = float(explained.sum() / self.expected[number])
            growth = math.log(min(max(ratio, 0.02), 50.0))
            overshot = growth * self.growth[number] < 0.0
            self.power[number] = max(0.5 * self.power[number], 0.2) if overshot else self.power[number]
            self.growth[number] = growth
            least = _LEAST * self.problem.noises[number].guess ** 2
            if growth < 0.0 and self.variances[number] <= least:
                continue  # data without this noise, as simulations have
            self.variances[number] = max(
                self.variances[number] * math.exp(growth * self.power[number]), least
            )
            largest = max(largest, abs(growth) * math.sqrt(self.expected[number]))
        return largest

    def _weigh(self, chains: Chains, square: Array) -> float:
        """Weigh fixes by their squared distances from the prediction by all others; return the change."""
        components = np.isfinite(chains.measured).sum(axis=1)
        weights = outlier_weights(square, components)
        moved = float(np.abs(weights - self.weights).max(initial=0.0))
        self.weights, self.distance = np.sqrt(weights * self.weights), np.sqrt(square)
        return moved

    def _freedom(self, number: int, covariance: Array) -> tuple[float, float]:
        """Return the degrees of freedom of a variance's estimate, and its influence on the coordinates.

        The first is twice the information on its logarithm, which is the rate at which the part that it is
        expected to explain, tr(V^-1 V_j), falls when the variance grows. The second is the largest derivative
        of the logarithm of a coordinate's variance by the logarithm of this variance.
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
        # The grown variance explains more by its own factor, which is divided out.
        slope_of_rest = (float(expected.sum()) * math.exp(-_GROWTH) - self.expected[number]) / _GROWTH
        before, after = np.diag(covariance)[self.free], np.diag(bound)[self.free]
        return float(max(-slope_of_rest, 0.0)), float(np.abs(np.log(after / before)).max()) / _GROWTH

    def result(self, held: tuple[Held, ...]) -> Estimate:
        """Return the estimate."""
        problem, fixes = self.problem, self.problem.fixes()
        covariance = information_bound(self.information, self.free)
        known = [self._freedom(number, covariance) for number in range(len(self.variances))]
        # Satterthwaite (1946): the uncertainties of the variances add, each times its squared influence
        relative = sum(influence**2 / freedom for freedom, influence in known if freedom > 0.0)
        sigmas = np.array([coordinate.prior_sigma for coordinate in problem.coordinates])[self.free]
        scaled = self.information[np.ix_(self.free, self.free)] * np.outer(sigmas, sigmas)
        worst = [int(k) for k in np.argsort(self.weights) if self.weights[k] < _NAMED]
        return Estimate(
            problem.coordinates,
            np.where(self.free, self.coordinates, 0.0),
            covariance,
            held,
            float(np.linalg.cond(scaled)),
            tuple(
                NoiseLevel(noise, float(np.sqrt(variance)), float(freedom))
                for noise, variance, (freedom, _) in zip(problem.noises, self.variances, known, strict=True)
            ),
            1.0 / max(relative, 1e-6),
            tuple(DownWeighted(*fixes[k], float(self.distance[k]), float(self.weights[k])) for k in worst),
            len(self.weights),
            self.rms,
        )
