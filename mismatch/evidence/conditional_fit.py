"""Data and candidates given a set of members, which are projected out, and the odds of each candidate there.

Every robot has a little of many effects: this background, and the members of a set, are nuisances with normal
priors that are integrated out (Frisch-Waugh-Lovell). A candidate is judged by the residuals:

- the Bayes factor of a fault, whose size is normal with the standard deviation that the effect declares (and,
  in one fault of five, five times that), against none;
- the log predictive density of held-out stretches (Gelman et al., Bayesian Data Analysis, 2013, section 7.2),
  against none. The smaller of the two counts.

Where the model is wrong, whitened noise is not white: the scores of stretches of time are overdispersed, and
the candidate's information is divided by that factor (Ribatet, Cooley & Davison, Statistica Sinica 2012: the
magnitude adjustment; White, Econometrica 1982). Laws are not exact either: in every stretch a member may
deviate from its law by a declared share, the discrepancy, which is noise to all others.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from omnimate.mismatch.candidates.regression import slices_of
from omnimate.mismatch.evidence.density import (
    MEMBER_SIZE,
    background_log_bayes_factor,
    heldout_log_density_gain,
    log_bayes_factor,
    log_evidence,
    without_background_prior,
)
from omnimate.mismatch.evidence.rows import (
    apply_discrepancy,
    discrepancy_factor,
    nuisance_noise,
    products_by_group,
    unwhiten_nuisances,
    whiten_along,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray
    from scipy.sparse import csr_array

    from omnimate.mismatch.candidates.terms import Term
    from omnimate.mismatch.evidence.candidates import Candidates
    from omnimate.vehicle.se2 import Array

# Share of the noise's square in some channel that an unknown, lasting error must explain: the declared
# relevance, a twentieth of what a simulation misses.
MIN_UNKNOWN_EXPLAINED = 0.05
MAX_CANCELLING_SIZE = 3.0  # [declared sizes] of a member with a candidate that nearly cancels it
CANCELLING_GROWTH = 1.5  # factor by which such a member grows when the candidate joins
LINEAR_RANGE = 2.0  # factor on an effect's largest size: its column is the slope of a small step
OUTLIER_SECONDS = 3  # seconds that may be outliers: a lasting effect must also show in the rest
WHITE_PRIOR_STRETCHES = 4.0  # stretches that count a priori for white noise
MAX_SHARE_IN_ONE_PART = 0.5  # of the information or the gain in one fold: beyond it, finer folds are used
IMPOSSIBLE = -math.inf
BATCH = 32  # candidates whose further columns are in memory at once


@dataclass(frozen=True, slots=True)
class Judgement:
    """Odds, fit and evidence of a candidate, given a set."""

    coefficients: Array  # its size, in declared ones, shape `(k,)`
    covariance: Array  # of them, shape `(k, k)`
    overdispersion: float = 1.0  # factor by which squares of noise exceed those of white noise
    # log posterior odds that it is there: prior odds, and the smaller of the log Bayes factor (against none,
    # or an event of any robot) and of the gain in log predictive density, both with overdispersed noise
    log_odds: float = IMPOSSIBLE
    heldout_gain: float = IMPOSSIBLE  # in log predictive density of held-out data, with overdispersed noise
    white_log_odds: float = IMPOSSIBLE  # if noise is white: by these, rivals, which share it, are compared
    white_log_evidence: float = IMPOSSIBLE  # the same without the prior odds


class _Products(NamedTuple):
    """Products of all C columns, the data first, and what the n nuisances add to the noise."""

    variances: Array  # along each of r orthogonal axes, in those of the noise, `(r,)`
    directions: Array  # of the axes: what each one has of every nuisance, of unit length, `(n, r)`
    # of the columns with the axes, so that `explained.T @ explained` is what the nuisances explain, `(r, C)`
    explained: Array
    residual: Array  # of the residuals of all columns with each other, `(C, C)`


class ConditionalFit:
    """The data and all candidates, given a set of members: nuisances and members are projected out.

    Judgements are cached; arrays are recomputed on demand after `release`.
    """

    def __init__(self, candidates: Candidates, members: tuple[int, ...]) -> None:
        self.candidates, self.members = candidates, members
        self._judged: dict[int, Judgement] = {}
        self._residual_columns: dict[int, Array] = {}
        background, background_sizes = candidates.background
        member_columns = [column for member in members for column in candidates.columns(member)]
        self._nuisances = np.array([*background, *member_columns], np.int64)
        self._nuisance_sizes = np.concatenate((background_sizes, np.full(len(member_columns), MEMBER_SIZE)))
        self._largest_sizes = np.array(
            [candidates.terms[member].largest for member in members for _ in candidates.columns(member)]
        )

    def release(self) -> None:
        """Drop the cached arrays that are as long as columns."""
        for name in ("_rows", "_products", "_axes", "residual"):
            self.__dict__.pop(name, None)
        self._residual_columns.clear()

    @cached_property
    def residual(self) -> Array:
        """Residual of the data, whitened, `(V,)`."""
        return self.residual_columns([0])[:, 0]

    @cached_property
    def _discrepancy_model(self) -> tuple[Array, csr_array] | None:
        """Row weights and factor that whiten the members' discrepancies; None where these are negligible."""
        part = self._member_discrepancies()
        if float((part**2).sum()) <= 1.0:
            return None
        weight = self._row_weights(part)
        return weight, discrepancy_factor(part * weight, self.candidates.stretch)

    @cached_property
    def _rows(self) -> Array:
        """All columns, the data first, with the members' discrepancies as noise, `(V, C)`."""
        return self._apply_discrepancy(self.candidates.regression.white)

    @cached_property
    def _products(self) -> _Products:
        gram = self._rows.T @ self._rows
        shared = self._nuisance_sizes[:, None] * gram[self._nuisances]
        variances, directions = nuisance_noise(shared[:, self._nuisances] * self._nuisance_sizes)
        explained = (directions / np.sqrt(1.0 + variances)).T @ shared
        return _Products(variances, directions, explained, gram - explained.T @ explained)

    @cached_property
    def _axes(self) -> Array:
        """Orthonormal axes of the nuisances, `(V, r)`."""
        variances, directions, *_ = self._products
        return np.asarray(
            self._rows[:, self._nuisances] @ (self._nuisance_sizes[:, None] * directions / np.sqrt(variances))
        )

    def gram_and_score(self, columns: Sequence[int] | NDArray[np.int64]) -> tuple[Array, Array]:
        """Return products of the residuals of some columns with each other (k, k), and with the data (k,)."""
        residual, index = self._products.residual, np.asarray(columns, np.int64)
        return residual[index[:, None], index], residual[index, 0]

    def residual_columns(self, columns: Sequence[int] | NDArray[np.int64]) -> Array:
        """Return the residuals of some columns, `(V, k)`."""
        return self._whitened(self._rows[:, columns], self._products.explained[:, columns])

    def _whitened(self, columns: Array, explained: Array) -> Array:
        """Return columns (V, C) whitened with the nuisances as noise, which explain (r, C) of them."""
        variances = self._products.variances
        along = np.sqrt((1.0 + variances) / variances)[:, None] * explained
        return whiten_along(columns, self._axes, variances, along)

    def _apply_discrepancy(self, rows: Array) -> Array:
        """Return rows (V, C) whitened with the members' discrepancies as noise."""
        if self._discrepancy_model is None:
            return rows
        weight, factor = self._discrepancy_model
        return apply_discrepancy(rows * weight, factor)

    def _member_coefficients(self, columns: Sequence[int]) -> Array:
        """Return the coefficients `(n, k)` of the members in a fit to some columns."""
        first, products = len(self._nuisance_sizes) - len(self._largest_sizes), self._products
        coefficients = products.directions[first:] / np.sqrt(1.0 + products.variances)
        return np.asarray(MEMBER_SIZE * (coefficients @ products.explained[:, columns]))

    def _member_discrepancies(self) -> Array:
        """Return one standard deviation of each member's discrepancy from its law, `(V, k)`."""
        white, ranges = self.candidates.regression.white, [*map(self.candidates.columns, self.members)]
        columns = white[:, [column for of_member in ranges for column in of_member]]
        precision = columns.T @ columns + np.eye(columns.shape[1]) / MEMBER_SIZE**2
        sizes = np.linalg.solve(precision, columns.T @ white[:, 0])
        parts = [np.zeros((len(white), 0))]
        for member, part in zip(self.members, slices_of(map(len, ranges)), strict=True):
            discrepancy = self.candidates.terms[member].discrepancy
            parts.append(discrepancy * columns[:, part] @ sizes[part, None])
        return np.hstack(parts)

    def _nearly_cancels(self, sizes_with: Array) -> bool:
        """Say whether a candidate nearly cancels a member, whose size with it (n,) becomes implausible.

        Such a pair would fit the difference of their two laws, neither of which is exact.
        """
        with_candidate, without = np.abs(sizes_with), np.abs(self._member_coefficients([0])[:, 0])
        grown = (with_candidate > CANCELLING_GROWTH * without) & (with_candidate > MAX_CANCELLING_SIZE)
        return bool(np.any(grown & np.isfinite(self._largest_sizes)))

    def _row_weights(self, part: Array) -> Array:
        """Return the weights (V, 1) of rows, given discrepancies (V, k): smaller where members are strong."""
        second = self.candidates.second
        power = (part**2).sum(axis=1)
        count = np.maximum(np.bincount(second), 1)
        mean = np.bincount(second, weights=power) / count
        return np.asarray(1.0 / np.sqrt(1.0 + mean[second]))[:, None]

    def z_scores(self, columns: Array) -> Array:
        """Return the signed z-score (C,) of the coefficient of each of further columns (V, C)."""
        columns, explained = self._with_nuisances(columns)
        information = np.einsum("vc,vc->c", columns, columns) - np.einsum("rc,rc->c", explained, explained)
        return np.asarray(self._score(columns, explained) / np.sqrt(np.maximum(information, 1e-12)))

    def project_out(self, columns: Array | NDArray[np.float32]) -> Array:
        """Return the residuals of further columns (V, C)."""
        return self._whitened(*self._with_nuisances(columns))

    def products_of(self, columns: Array) -> tuple[Array, Array]:
        """Return products of further columns (V, C) with each other (C, C), and with the data (C,)."""
        columns, explained = self._with_nuisances(columns)
        return columns.T @ columns - explained.T @ explained, self._score(columns, explained)

    def log_bayes_factors(self, columns: Array | NDArray[np.float32], widths: Sequence[int]) -> Array:
        """Return the log Bayes factors (K,) of candidates with so many of further columns (V, C) each."""
        places, factors = slices_of(widths), []
        for batch in (places[first : first + BATCH] for first in range(0, len(places), BATCH)):
            start = batch[0].start
            of_batch, explained = self._with_nuisances(columns[:, start : batch[-1].stop])
            score, width = self._score(of_batch, explained), max(place.stop - place.start for place in batch)
            # columns of zeros change nothing
            grams, scores = np.zeros((len(batch), width, width)), np.zeros((len(batch), width))
            for number, part in enumerate(slice(place.start - start, place.stop - start) for place in batch):
                own = slice(part.stop - part.start)
                grams[number, own, own] = of_batch[:, part].T @ of_batch[:, part]
                grams[number, own, own] -= explained[:, part].T @ explained[:, part]
                scores[number, own] = score[part]
            factors.append(log_bayes_factor(grams, scores))
        return np.concatenate(factors)

    def _with_nuisances(self, columns: Array | NDArray[np.float32]) -> tuple[Array, Array]:
        """Return further columns (V, C) with discrepancies as noise, and what nuisances explain, `(r, C)`."""
        columns = self._apply_discrepancy(columns.astype(np.float64, copy=False))
        variances = self._products.variances
        return columns, np.sqrt(variances / (1.0 + variances))[:, None] * (self._axes.T @ columns)

    def _score(self, columns: Array, explained: Array) -> Array:
        """Return products (C,) of the residuals of columns (V, C) with the data."""
        return np.asarray(self._rows[:, 0] @ columns - self._products.explained[:, 0] @ explained)

    def products_without_background(self, candidates: Iterable[int]) -> tuple[Array, Array]:
        """Return products of candidates' columns with each other (k, k) and with the data (k,).

        They are for a robot without the background of the candidates' effects.
        """
        chosen = list(candidates)
        columns = [column for candidate in chosen for column in self.candidates.columns(candidate)]
        keys = {self.candidates.terms[candidate].key for candidate in chosen}
        background, sizes = self.candidates.background_of(keys)
        return without_background_prior(*self.gram_and_score([*columns, *background]), sizes)

    def background_log_bayes_factor(self, keys: set[tuple[str, str]], spread: float = 1.0) -> float:
        """Return the log Bayes factor of some effects' background against none, in overdispersed noise."""
        columns, sizes = self.candidates.background_of(keys)
        return float(background_log_bayes_factor(*self.gram_and_score(columns), sizes, spread))

    @cached_property
    def approximate_log_odds(self) -> Array:
        """Log posterior odds of each candidate if noise is white and its law is exact."""
        products, terms = self._products.residual, self.candidates.terms
        log_odds = np.array([self.candidates.odds(number, self.members) for number in range(len(terms))])
        for group in self.candidates.groups_of_equal_shape():
            count = group.sizes.shape[1]
            first = group.columns.shape[1] - count
            gram = products[group.columns[:, :, None], group.columns[:, None, :]]
            score = products[group.columns, 0]
            background = background_log_bayes_factor(gram[:, first:, first:], score[:, first:], group.sizes)
            gram, score = without_background_prior(gram, score, group.sizes)
            log_odds[group.numbers] += log_bayes_factor(gram, score) - background
            if group.nuisance_size > 0.0:
                log_odds[group.numbers] -= log_evidence(gram, score, group.nuisance_size)
            positive = np.array([terms[candidate].positive for candidate in group.numbers])
            log_odds[group.numbers[positive & np.any(score < 0.0, axis=1)]] = IMPOSSIBLE
        return log_odds

    def judge_all(self, candidates: Sequence[int]) -> list[Judgement]:
        """Return the judgements of candidates; the residuals of all their columns are computed at once."""
        terms = self.candidates.terms
        columns = {
            int(column)
            for candidate in candidates
            if candidate not in self._judged
            for column in (
                *self.candidates.columns(candidate),
                *self.candidates.background_of({terms[candidate].key})[0],
            )
        }
        self._compute_residuals(columns)
        return [self.judge(candidate) for candidate in candidates]

    def judge(self, candidate: int) -> Judgement:
        """Return the judgement of a candidate, against a robot that has the background of its effect."""
        if candidate not in self._judged:
            self._judged[candidate] = self._judgement(candidate)
        return self._judged[candidate]

    def _judgement(self, candidate: int) -> Judgement:
        columns = list(self.candidates.columns(candidate))
        term = self.candidates.terms[candidate]
        rows, residual = self._without_background(columns, term.key)
        whole = gram, score = rows.T @ rows, rows.T @ residual
        prior = np.eye(len(columns)) / MEMBER_SIZE**2
        fitted: Array = np.asarray(np.linalg.solve(gram + prior, score), np.float64)
        lasting = term.is_unknown and not term.is_local
        invisible = lasting and self._largest_share(rows @ fitted) < MIN_UNKNOWN_EXPLAINED
        sizes_with = self._member_coefficients([0])[:, 0] - self._member_coefficients(columns) @ fitted
        if invisible or self._nearly_cancels(sizes_with):
            covariance = np.linalg.inv(gram + prior).astype(np.float64)
            return Judgement(fitted, covariance)
        after, discrepancy_gain = residual - rows @ fitted, 0.0
        if term.stretches and term.effect != "unknown":
            weight = self._discrepancy_weights(term.discrepancy * rows @ fitted, after)
            discrepancy_gain = _weighting_gain(residual, weight)
            rows, residual, after = rows * weight[:, None], residual * weight, after * weight
            gram, score = rows.T @ rows, rows.T @ residual
        overdispersion = self._overdispersion(rows, after, gram)
        white_evidence = self._evidence(term, gram, score, discrepancy_gain)
        evidence = self._evidence(term, gram, score, discrepancy_gain, overdispersion)
        if term.ordinary_size > 0.0:
            ordinary = log_evidence(whole[0] / overdispersion, whole[1] / overdispersion, term.ordinary_size)
            evidence -= max(0.0, float(ordinary))
        covariance = np.linalg.inv(gram / overdispersion + prior).astype(np.float64)
        coefficients = np.asarray(covariance @ (score / overdispersion))
        absurd = np.any(np.abs(coefficients) > LINEAR_RANGE * term.largest)
        prior_log_odds = self.candidates.odds(candidate, self.members)
        if (term.positive and np.any(coefficients < 0.0)) or absurd:
            return Judgement(coefficients, covariance, overdispersion)
        folds = self._products_by_fold(rows, residual)
        heldout_gain = heldout_log_density_gain(*folds, overdispersion) + discrepancy_gain / overdispersion
        if heldout_gain > 0.0 and not term.is_local:
            gain = residual**2 - after**2
            outlying = self._strongest_seconds(gain)
            if gain @ outlying > MAX_SHARE_IN_ONE_PART * gain.sum():
                halves = products_by_group(outlying, rows, residual)
                heldout_gain = min(heldout_gain, heldout_log_density_gain(*halves, overdispersion))
        white_gain = heldout_gain
        if overdispersion != 1.0:
            white_gain = heldout_log_density_gain(*folds, 1.0) + discrepancy_gain
        white_log_evidence = min(white_evidence, white_gain)
        return Judgement(
            coefficients,
            covariance,
            overdispersion,
            prior_log_odds + min(evidence, heldout_gain),
            heldout_gain,
            prior_log_odds + white_log_evidence,
            white_log_evidence,
        )

    def _largest_share(self, part: Array) -> float:
        """Return the share of the noise's square that a part (V,) has in its strongest channel."""
        channel = self.candidates.regression.channel
        rows = np.maximum(np.bincount(channel), 1)
        return float((np.bincount(channel, weights=part**2) / rows).max())

    def _evidence(
        self, term: Term, gram: Array, score: Array, discrepancy_gain: float, overdispersion: float = 1.0
    ) -> float:
        """Return the log Bayes factor of a candidate against a robot with the background of its effect.

        `gram` (k, k) and `score` (k,) are products of its columns' residuals; `discrepancy_gain` is the log
        likelihood that the weights of its discrepancy add.
        """
        gram, score = gram / overdispersion, score / overdispersion
        evidence = float(log_bayes_factor(gram, score))
        evidence -= self.background_log_bayes_factor({term.key}, overdispersion)
        evidence += discrepancy_gain / overdispersion
        if term.nuisance_size > 0.0:
            evidence -= float(log_evidence(gram, score, term.nuisance_size))
        return evidence

    def _compute_residuals(self, columns: Iterable[int]) -> None:
        """Compute the residuals of some columns, unless they are cached."""
        missing = sorted(set(columns) - self._residual_columns.keys())
        if missing:
            self._residual_columns.update(zip(missing, self.residual_columns(missing).T.copy(), strict=True))

    def _without_background(self, columns: Sequence[int], key: tuple[str, str]) -> tuple[Array, Array]:
        """Return residuals of columns (V, k) and data (V,), for a robot without an effect's background."""
        background, sizes = self.candidates.background_of({key})
        self._compute_residuals([*columns, *background.tolist()])
        rows = np.column_stack([self.residual, *(self._residual_columns[column] for column in columns)])
        if len(background):
            nuisances = np.column_stack([self._residual_columns[column] for column in background.tolist()])
            rows = unwhiten_nuisances(rows, nuisances * sizes)
        return rows[:, 1:], rows[:, 0]

    def bootstrap_gain(self, candidate: int, draws: Array) -> Array:
        """Return changes (n,) of a log Bayes factor with stretches drawn so often, `(n, stretches)`."""
        term = self.candidates.terms[candidate]
        rows, residual = self._without_background(list(self.candidates.columns(candidate)), term.key)
        gram, score = products_by_group(self.candidates.stretch, rows, residual)
        of_all = log_bayes_factor(gram.sum(axis=0), score.sum(axis=0))
        scores = draws @ score
        gain = log_bayes_factor(np.tensordot(draws, gram, 1), scores)
        if term.positive:
            gain[np.any(scores < 0.0, axis=1)] = IMPOSSIBLE
        return gain - of_all

    def _discrepancy_weights(self, part: Array, after: Array) -> Array:
        """Return the weights (V,) of rows if an event is likelier with discrepancy; ones if it is not.

        Rivals of free shape, such as a push, would otherwise win by the discrepancy alone, which would also
        count as overdispersion. `part` (V,) is one standard deviation of the discrepancy, and `after` (V,)
        the residual with the event.
        """
        weight = self._row_weights(part[:, None])[:, 0]
        return weight if _weighting_gain(after, weight) > 0.0 else np.ones_like(weight)

    def _overdispersion(self, columns: Array, after: Array, gram: Array) -> float:
        """Return the factor by which squared scores of rows or stretches exceed those of white noise."""
        stretch = self.candidates.stretch
        count = int(stretch.max()) + 1
        scores = np.stack(
            [np.bincount(stretch, weights=column * after, minlength=count) for column in columns.T], axis=1
        )
        power = (columns**2).sum(axis=1)
        information = np.bincount(stretch, weights=power, minlength=count)
        # Kish's effective sample size
        effective = float(information.sum() ** 2 / max((information**2).sum(), 1e-300))
        inverse = np.linalg.inv(gram + 1e-9 * np.eye(len(gram)))
        ratio = float(np.einsum("bi,ij,bj->", scores, inverse, scores)) / len(gram)
        ratio *= effective / max(effective - 1.0, 1.0)
        uneven = float(power @ after**2 / max(power.sum(), 1e-300))
        known = WHITE_PRIOR_STRETCHES
        return max(1.0, uneven, (known + effective * ratio) / (known + effective))

    def _strongest_seconds(self, gain: Array) -> NDArray[np.int64]:
        """Return which rows (V,) are of the few seconds with the largest gains, of gains (V,)."""
        moment = self.candidates.moment
        gains = np.bincount(moment, weights=gain)
        return np.isin(moment, np.argsort(-gains)[:OUTLIER_SECONDS]).astype(np.int64)

    def _products_by_fold(self, columns: Array, residual: Array) -> tuple[Array, Array]:
        """Return products of columns (V, k) with each other (F, k, k) and the data (F, k), in each fold."""
        fold = self.candidates.fold
        information = np.bincount(fold, weights=(columns**2).sum(axis=1))
        if information.max() > MAX_SHARE_IN_ONE_PART * information.sum():
            fold = self.candidates.moments
        return products_by_group(fold, columns, residual)


def _weighting_gain(rows: Array, weight: Array) -> float:
    """Return by how much weights (V,) raise the log likelihood of rows (V,)."""
    return 0.5 * float((rows**2 * (1.0 - weight**2)).sum()) + float(np.log(weight).sum())
