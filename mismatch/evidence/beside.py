"""What is left of recordings beside a set of members, and what a candidate is worth there.

Every robot has a little of many effects: these everyday sizes, and the members of a set, are noise to all
others (Frisch-Waugh-Lovell with normal priors), and a candidate is judged by what is left:

- the Bayes factor of a fault, whose size is normal with the standard deviation that the effect declares (and,
  in one fault of five, five times that), against none;
- the log predictive density of stretches that its fit has not seen (Gelman et al., Bayesian Data Analysis,
  2013, section 7.2), against none. The smaller of the two counts.

Whitened noise of a robot that is modelled wrongly is not white. The scores of stretches of time then scatter
more than they should; by that factor a candidate's information is smaller (Ribatet, Cooley & Davison,
Statistica Sinica 2012: the magnitude adjustment; White, Econometrica 1982). No law is exact either: in every
stretch a member may act by a part more or less than its law says, which is noise to all others.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from omnimate.mismatch.evidence.density import (
    LARGEST,
    bared,
    bayes_factor,
    earned,
    everyday_factor,
    log_evidence,
    log_prior,
)
from omnimate.mismatch.evidence.rows import loosened, loosening, narrowed, products_by_group, shrinking

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray
    from scipy.sparse import csr_array

    from omnimate.mismatch.candidates.terms import Term
    from omnimate.mismatch.evidence.candidates import Candidates
    from omnimate.vehicle.se2 import Array

SEEN = 0.05  # of the noise's square: what has no name is told where one sees it in the residual
CANCELLING = 3.0  # declared sizes of two faults that nearly cancel, beyond which nobody believes in both
LINEAR = 2.0  # times as large as it is, a fault may look by a column that is of a small step of its size
GROWN = 1.5  # times its size that a member grows when what nearly cancels it joins
MOMENTS = 3  # seconds that may be outliers: what acts all the time must be seen in them and in the rest
KNOWN = 4.0  # stretches that say, before any is seen, that noise is white
CONCENTRATED = (
    0.5  # of the information, or of the gain, in one part of the data, from which others must show it
)
NOTHING = -math.inf


@dataclass(frozen=True, slots=True)
class Judgement:
    """What a candidate is worth beside a set.

    Attributes:
        worth: Log posterior odds that it is there, of the evidence and what it earns the smaller.
        evidence: Log Bayes factor.
        earned: Gain in log predictive density of data that its fit has not seen.
        coefficients: Its size, in declared ones, shape `(k,)`.
        covariance: Of them, shape `(k, k)`.
        spread: Factor by which squares of noise are larger than they should be.
        rank: What it is worth against rivals, as log odds: they share the noise, and none may widen it for
            itself, so that it counts as white.
        support: Of that what the data say: without the prior odds.
    """

    worth: float
    evidence: float
    earned: float
    coefficients: Array
    covariance: Array
    spread: float
    rank: float = NOTHING
    support: float = NOTHING


class _Products(NamedTuple):
    """Products of all C columns, the data first, and of the n nuisances.

    Attributes:
        inside: Of the nuisances with each other, `(n, n)`.
        root: Cholesky factor of their precision, `(n, n)`, as `cho_factor` gives it.
        shared: Of the nuisances with all columns, `(n, C)`.
        held: Coefficients of the nuisances in a fit of them to each column, `(n, C)`.
        left: Of what is left of all columns with each other, `(C, C)`.
    """

    inside: Array
    root: tuple[Array, bool]
    shared: Array
    held: Array
    left: Array


class Beside:
    """What is left of the data and of all candidates beside a set of members.

    What it says of candidates is kept; the arrays that it is made of are made again after `release`.
    """

    def __init__(self, candidates: Candidates, members: tuple[int, ...]) -> None:
        self.candidates, self.members = candidates, members
        self._judged: dict[int, Judgement] = {}
        self._left_rows: dict[int, Array] = {}
        everyday, usual = candidates.everyday
        own = [at for single in members for at in candidates.columns(single)]
        self._nuisances = np.array([*everyday, *own], np.int64)
        self._sizes = np.concatenate((usual, np.full(len(own), LARGEST)))
        self._most = np.array(
            [candidates.terms[single].most for single in members for _ in candidates.columns(single)]
        )

    def release(self) -> None:
        """Forget all arrays as long as columns are."""
        for name in ("_rows", "_products", "_shrunk", "residual"):
            self.__dict__.pop(name, None)
        self._left_rows.clear()

    @cached_property
    def residual(self) -> Array:
        """What is left of the data, `(V,)`."""
        return self.columns([0])[:, 0]

    @cached_property
    def _laws(self) -> tuple[Array, csr_array] | None:
        """How rows are whitened anew where the members' laws are not exact, if they are strong enough."""
        part = self._discrepancy()
        if float((part**2).sum()) <= 1.0:
            return None
        weight = self._weight(part)
        return weight, loosening(part * weight, self.candidates.stretch)

    @cached_property
    def _rows(self) -> Array:
        """All columns, the data first, with members being noise where their laws are not exact, `(V, C)`."""
        return self._loosened(self.candidates.regression.white)

    @cached_property
    def _products(self) -> _Products:
        every = self._rows.T @ self._rows
        shared = self._sizes[:, None] * every[self._nuisances]
        inside = shared[:, self._nuisances] * self._sizes
        root = cho_factor(inside + np.eye(len(inside)))
        held = cho_solve(root, shared)
        return _Products(inside, root, shared, held, every - shared.T @ held)

    @cached_property
    def _shrunk(self) -> Array:
        return shrinking(self._products.inside)

    def left(self, columns: Sequence[int] | NDArray[np.int64]) -> tuple[Array, Array]:
        """Return products of what is left of some columns with each other (k, k), and with the data (k,)."""
        left, at = self._products.left, np.asarray(columns, np.int64)
        return left[at[:, None], at], left[at, 0]

    def columns(self, columns: Sequence[int] | NDArray[np.int64]) -> Array:
        """Return what is left of some columns, `(V, k)`."""
        weights = np.zeros((self._rows.shape[1], len(columns)))
        taken = self._shrunk @ self._products.shared[:, columns]
        np.add.at(weights, self._nuisances, -self._sizes[:, None] * taken)
        weights[columns, range(len(columns))] += 1.0
        return np.asarray(self._rows @ weights)

    def _loosened(self, rows: Array) -> Array:
        """Return rows (V, C) whitened anew, members being noise where their laws are not exact."""
        if self._laws is None:
            return rows
        weight, by = self._laws
        return loosened(rows * weight, by)

    def _held(self, columns: Sequence[int]) -> Array:
        """Return what of some columns the members hold, in their coefficients, `(n, k)`."""
        return LARGEST * self._products.held[len(self._sizes) - len(self._most) :][:, columns]

    def _discrepancy(self) -> Array:
        """Return what members may do otherwise than their laws say, `(V, k)`."""
        terms, white = self.candidates.terms, self.candidates.regression.white
        columns = white[:, [at for single in self.members for at in self.candidates.columns(single)]]
        precision = columns.T @ columns + np.eye(columns.shape[1]) / LARGEST**2
        sizes = np.linalg.solve(precision, columns.T @ white[:, 0])
        parts, first = [np.zeros((len(white), 0))], 0
        for single in self.members:
            here = slice(first, first + len(self.candidates.columns(single)))
            parts.append(terms[single].inexact * columns[:, here] @ sizes[here, None])
            first = here.stop
        return np.hstack(parts)

    def _cancels(self, with_it: Array) -> bool:
        """Say whether a candidate makes members absurdly large, which it then nearly cancels.

        Such a pair would be believed for what the two laws, neither exact, leave of each other.

        Args:
            with_it: Sizes of the members beside the candidate, `(n,)`.
        """
        sizes, without = np.abs(with_it), np.abs(self._held([0])[:, 0])
        grown = (sizes > GROWN * without) & (sizes > CANCELLING)
        return bool(np.any(grown & np.isfinite(self._most)))

    def _rarer(self, with_it: Array) -> float:
        """Return by how much members are less likely a priori at the sizes that a candidate drives them to.

        Members are integrated out with one wide normal prior; that of faults has two parts.

        Args:
            with_it: Sizes of the members beside the candidate, `(n,)`.
        """
        return min(0.0, float((log_prior(with_it) - log_prior(self._held([0])[:, 0])).sum()))

    def _weight(self, part: Array) -> Array:
        """Return the weights (V, 1) of rows: where members are strong, their shapes are not exact."""
        second = self.candidates.second
        power = (part**2).sum(axis=1)
        count = np.maximum(np.bincount(second), 1)
        mean = np.bincount(second, weights=power) / count
        return np.asarray(1.0 / np.sqrt(1.0 + mean[second]))[:, None]

    def strength(self, added: Array) -> Array:
        """Return by how many sigma (C,) each of added columns (V, C) would be estimated, signed."""
        added, shared, held = self._with(added)
        information = np.einsum("vc,vc->c", added, added) - np.einsum("nc,nc->c", shared, held)
        return np.asarray(self._score(added, held) / np.sqrt(np.maximum(information, 1e-12)))

    def free(self, added: Array) -> Array:
        """Return added columns (V, C) as what is left of them."""
        added, shared, _ = self._with(added)
        weights = np.zeros((self._rows.shape[1], added.shape[1]))
        np.add.at(weights, self._nuisances, self._sizes[:, None] * (self._shrunk @ shared))
        return np.asarray(added - self._rows @ weights)

    def scores(self, added: Array) -> tuple[Array, Array]:
        """Return products of added columns (V, C) with each other (C, C), and with the data (C,)."""
        added, shared, held = self._with(added)
        return added.T @ added - shared.T @ held, self._score(added, held)

    def supports(self, added: Array, widths: Sequence[int]) -> Array:
        """Return the log Bayes factors (K,) of candidates that have so many of added columns (V, C) each."""
        added, shared, held = self._with(added)
        score, found, first = self._score(added, held), [], 0
        for width in widths:
            own = slice(first, first + width)
            gram = added[:, own].T @ added[:, own] - shared[:, own].T @ held[:, own]
            found.append(float(bayes_factor(gram, score[own])))
            first += width
        return np.array(found)

    def _with(self, added: Array) -> tuple[Array, Array, Array]:
        """Return added columns (V, C) with members being noise, and what they share with the nuisances.

        That is their products (n, C), and the nuisances' coefficients (n, C) in a fit to them.
        """
        added = self._loosened(added)
        shared = self._sizes[:, None] * (self._rows.T @ added)[self._nuisances]
        return added, shared, cho_solve(self._products.root, shared)

    def _score(self, added: Array, held: Array) -> Array:
        """Return products (C,) of what is left of columns (V, C), given what nuisances hold of them."""
        return np.asarray(self._rows[:, 0] @ added - self._products.shared[:, 0] @ held)

    def products(self, candidates: Iterable[int]) -> tuple[Array, Array]:
        """Return products of candidates' columns with each other (k, k) and with the data (k,).

        They are for a robot without any everyday size of what the candidates are called.
        """
        chosen = list(candidates)
        columns = [at for single in chosen for at in self.candidates.columns(single)]
        same, sizes = self.candidates.same({self.candidates.terms[single].key for single in chosen})
        return bared(*self.left([*columns, *same]), sizes)

    def everyday(self, keys: set[tuple[str, str]], spread: float = 1.0) -> float:
        """Return the log Bayes factor of the everyday sizes of some names against none of them.

        Args:
            keys: Effects and components.
            spread: Factor by which squares of noise are larger than they should be.
        """
        same, sizes = self.candidates.same(keys)
        return float(everyday_factor(*self.left(same), sizes, spread))

    def quick(self, single: int) -> float:
        """Return a candidate's log posterior odds if noise is white and its law holds everywhere."""
        return float(self._quick[single])

    @cached_property
    def _quick(self) -> Array:
        """The quick odds of all candidates."""
        left, terms = self._products.left, self.candidates.terms
        worth = np.array([self.candidates.odds(single, self.members) for single in range(len(terms))])
        for group in self.candidates.alike():
            count = group.sizes.shape[1]
            first = group.columns.shape[1] - count
            gram, score = left[group.columns[:, :, None], group.columns[:, None, :]], left[group.columns, 0]
            usual = everyday_factor(gram[:, first:, first:], score[:, first:], group.sizes)
            gram, score = bared(gram, score, group.sizes)
            worth[group.numbers] += bayes_factor(gram, score) - usual
            if group.ordinary > 0.0:
                worth[group.numbers] -= log_evidence(gram, score, group.ordinary)
            positive = np.array([terms[single].positive for single in group.numbers])
            worth[group.numbers[positive & np.any(score < 0.0, axis=1)]] = NOTHING
        return worth

    def judge_all(self, candidates: Sequence[int]) -> list[Judgement]:
        """Return what candidates are worth; what is left of their columns is made at once."""
        terms = self.candidates.terms
        columns = {
            int(column)
            for single in candidates
            if single not in self._judged
            for column in (*self.candidates.columns(single), *self.candidates.same({terms[single].key})[0])
        }
        self._make(columns)
        return [self.judge(single) for single in candidates]

    def judge(self, single: int) -> Judgement:
        """Return what a candidate is worth, against a robot that has an everyday size of it."""
        if single not in self._judged:
            self._judged[single] = self._judgement(single)
        return self._judged[single]

    def _judgement(self, single: int) -> Judgement:
        columns = list(self.candidates.columns(single))
        term = self.candidates.terms[single]
        own, residual = self._apart(columns, term.key)
        gram, score = own.T @ own, own.T @ residual
        size = np.eye(len(columns)) / LARGEST**2
        fitted: Array = np.asarray(np.linalg.solve(gram + size, score), np.float64)
        lasting = term.is_unknown and not term.is_local
        quiet = lasting and float(fitted @ gram @ fitted) < SEEN * len(residual)
        with_it = self._held([0])[:, 0] - self._held(columns) @ fitted
        if quiet or self._cancels(with_it):
            covariance = np.linalg.inv(gram + size).astype(np.float64)
            return Judgement(NOTHING, NOTHING, NOTHING, fitted, covariance, 1.0)
        after, loose = residual - own @ fitted, 0.0
        if term.stretches and term.effect != "unknown":
            weight = self._inexact(term.inexact * own @ fitted, after)
            loose = 0.5 * float((residual**2 * (1.0 - weight**2)).sum()) + float(np.log(weight).sum())
            own, residual, after = own * weight[:, None], residual * weight, after * weight
            gram, score = own.T @ own, own.T @ residual
        spread = self._spread(own, after, gram)
        white = float(bayes_factor(gram, score)) - self.everyday({term.key}) + loose
        white -= _ordinary(term, gram, score)
        gram, score = gram / spread, score / spread
        covariance = np.linalg.inv(gram + size).astype(np.float64)
        coefficients = np.asarray(covariance @ score)
        evidence = float(bayes_factor(gram, score)) - self.everyday({term.key}, spread) + loose / spread
        evidence -= _ordinary(term, gram, score)
        absurd = np.any(np.abs(coefficients) > LINEAR * term.most)
        prior = self.candidates.odds(single, self.members) + self._rarer(with_it)
        if (term.positive and np.any(coefficients < 0.0)) or absurd:
            return Judgement(NOTHING, NOTHING, NOTHING, coefficients, covariance, spread)
        folds = self._by_fold(own, residual)
        gained = earned(*folds, spread) + loose / spread
        if gained > 0.0 and not term.is_local:
            gain = residual**2 - after**2
            outlying = self._outlying(gain)
            if gain @ outlying > CONCENTRATED * gain.sum():
                gained = min(gained, earned(*products_by_group(outlying, own, residual), spread))
        support = min(white, gained if spread == 1.0 else earned(*folds, 1.0) + loose)
        worth, rank = prior + min(evidence, gained), prior + support
        return Judgement(worth, evidence, gained, coefficients, covariance, spread, rank, support)

    def _make(self, columns: Iterable[int]) -> None:
        """Make what is left of some columns, unless it is there."""
        missing = sorted(set(columns) - self._left_rows.keys())
        if missing:
            self._left_rows.update(zip(missing, self.columns(missing).T.copy(), strict=True))

    def _apart(self, columns: Sequence[int], key: tuple[str, str]) -> tuple[Array, Array]:
        """Return columns (V, k) and data (V,) for a robot without any everyday size of what has a name."""
        same, sizes = self.candidates.same({key})
        self._make([*columns, *same.tolist()])
        rows = np.column_stack([self.residual, *(self._left_rows[column] for column in columns)])
        if len(same):
            usual = np.column_stack([self._left_rows[column] for column in same.tolist()])
            rows = narrowed(rows, usual * sizes)
        return rows[:, 1:], rows[:, 0]

    def redrawn(self, single: int, draws: Array) -> Array:
        """Return by how much more a candidate is supported, (n,), with stretches drawn anew.

        Args:
            single: The candidate.
            draws: How often each stretch is drawn, `(n, stretches)`.
        """
        term = self.candidates.terms[single]
        own, residual = self._apart(list(self.candidates.columns(single)), term.key)
        gram, score = products_by_group(self.candidates.stretch, own, residual)
        whole = bayes_factor(gram.sum(axis=0), score.sum(axis=0))
        scores = draws @ score
        supported = bayes_factor(np.tensordot(draws, gram, 1), scores)
        if term.positive:
            supported[np.any(scores < 0.0, axis=1)] = NOTHING
        return supported - whole

    def _inexact(self, part: Array, after: Array) -> Array:
        """Return the weights (V,) of rows if an event is likelier not exactly of its shape; ones if it is.

        Rivals that are free in shape, as a push is, would otherwise explain what a law leaves that nobody
        holds for exact, and what it leaves would count as noise that is not white.

        Args:
            part: What it may do otherwise than its law says, one standard deviation, `(V,)`.
            after: What is left beside it, `(V,)`.
        """
        weight = self._weight(part[:, None])[:, 0]
        likelier = 0.5 * float((after**2 * (1.0 - weight**2)).sum()) + float(np.log(weight).sum())
        return weight if likelier > 0.0 else np.ones_like(weight)

    def _spread(self, own: Array, after: Array, gram: Array) -> float:
        """Return the factor by which scores of rows or stretches scatter more than unit noise does."""
        stretch = self.candidates.stretch
        count = int(stretch.max()) + 1
        scores = np.stack(
            [np.bincount(stretch, weights=column * after, minlength=count) for column in own.T], axis=1
        )
        power = (own**2).sum(axis=1)
        inside = np.bincount(stretch, weights=power, minlength=count)
        told = float(inside.sum() ** 2 / max((inside**2).sum(), 1e-300))  # stretches that tell anything
        inverse = np.linalg.inv(gram + 1e-9 * np.eye(len(gram)))
        ratio = float(np.einsum("bi,ij,bj->", scores, inverse, scores)) / len(gram)
        ratio *= told / max(told - 1.0, 1.0)
        uneven = float(power @ after**2 / max(power.sum(), 1e-300))
        return max(1.0, uneven, (KNOWN + told * ratio) / (KNOWN + told))

    def _outlying(self, gain: Array) -> NDArray[np.int64]:
        """Return which rows (V,) are of the few seconds in which most is gained, of gains (V,) of each."""
        moment = self.candidates.moment
        gains = np.bincount(moment, weights=gain)
        return np.isin(moment, np.argsort(-gains)[:MOMENTS]).astype(np.int64)

    def _by_fold(self, own: Array, residual: Array) -> tuple[Array, Array]:
        """Return products of columns (V, k) with each other (F, k, k) and the data (F, k), in each fold."""
        fold = self.candidates.fold
        inside = np.bincount(fold, weights=(own**2).sum(axis=1))
        if inside.max() > CONCENTRATED * inside.sum():
            fold = self.candidates.moments
        return products_by_group(fold, own, residual)


def _ordinary(term: Term, gram: Array, score: Array) -> float:
    """Return the log Bayes factor of what any robot meets of a candidate at some moment, against none."""
    return float(log_evidence(gram, score, term.ordinary)) if term.ordinary > 0.0 else 0.0
