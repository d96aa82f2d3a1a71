"""What a candidate is worth beside others: its Bayes factor, and what it earns on data that no fit has seen.

Rows are whitened, so that the data are `y = X beta + e` with white noise of size one. Every robot has a
little of many effects: these everyday sizes, and the members of a set, are integrated out first
(Frisch-Waugh-Lovell with normal priors), and a candidate is judged by what is left:

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

import itertools
import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import csr_array

from omnimate.mismatch.candidates.beliefs import NUMBER, NUMBERS, UNCALIBRATED

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from numpy.typing import NDArray

    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.candidates.terms import Term
    from omnimate.vehicle.se2 import Array

TAILS = ((1.0, 0.8), (5.0, 0.2))  # sizes of faults in declared ones, and how many faults are of them
LARGEST = 5.0  # declared sizes, one standard deviation of a member that is integrated out
SEEN = 0.05  # of the noise's square: what has no name is told where one sees it in the residual
CANCELLING = 3.0  # declared sizes of two faults that nearly cancel, beyond which nobody believes in both
LINEAR = 2.0  # times as large as it is, a fault may look by a column that is of a small step of its size
GROWN = 1.5  # times its size that a member grows when what nearly cancels it joins
STRETCH = 4.0  # [s] in which scores are summed: long against what a filter remembers of a wrong model
MOMENTS = 3  # seconds that may be outliers: what acts all the time must be seen in them and in the rest
FOLDS = 8  # into which data are cut to be held out in turn
KNOWN = 4.0  # stretches that say, before any is seen, that noise is white
CONCENTRATED = (
    0.5  # of the information, or of the gain, in one part of the data, from which others must show it
)
# Log odds of a bump in one window of 0.25 s on a floor that has two of them already: once a minute, as robots
# come to a joint between slabs every ten or twenty metres.
MANY, AGAIN = 2, math.log(1.0 / 240.0)
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


@dataclass(slots=True)
class Posterior:
    """Candidates and the recordings that judge them.

    Attributes:
        regression: With the columns of all candidates.
        terms: The candidates.
        places: Where each one's columns are.
        names: What each everyday column is called.
        shift: What of the data's column the base of the regression has taken away, shape `(V,)`.
        everyday: Columns of which every robot has a little, and how much, in declared sizes.
    """

    regression: Regression
    terms: list[Term]
    places: list[slice]
    everyday: tuple[NDArray[np.int64], Array]
    names: dict[int, tuple[str, str]]
    shift: Array
    stretch: NDArray[np.int64] = field(init=False)
    fold: NDArray[np.int64] = field(init=False)
    moments: NDArray[np.int64] = field(init=False)
    moment: NDArray[np.int64] = field(init=False)
    second: NDArray[np.int64] = field(init=False)
    called: dict[tuple[str, str], list[int]] = field(init=False)
    known: dict[frozenset[int], Beside] = field(default_factory=dict)

    def __post_init__(self) -> None:
        time, owner = self.regression.time, self.regression.owner
        starts = np.array([single.time[0] for single in self.regression.windows])
        spans = np.array([single.time[-1] - single.time[0] for single in self.regression.windows])
        before = np.concatenate(([0.0], np.cumsum(spans)[:-1]))
        along = time - starts[owner] + before[owner]  # the recordings end to end
        number = np.floor((time - starts[owner]) / STRETCH).astype(np.int64)
        _, self.stretch = np.unique(owner * 10**6 + number, return_inverse=True)
        self.fold = np.minimum((along / spans.sum() * FOLDS).astype(np.int64), FOLDS - 1)
        _, self.second = np.unique(
            np.stack([owner, self.regression.channel, np.floor(time - starts[owner]).astype(np.int64)]),
            axis=1,
            return_inverse=True,
        )
        self.second = self.second.ravel()
        _, self.moment = np.unique(
            owner * 10**6 + np.floor(time - starts[owner]).astype(np.int64), return_inverse=True
        )
        self.moments = (np.floor(along).astype(np.int64)) % 2
        self.called = {}
        for place, column in enumerate(self.everyday[0].tolist()):
            self.called.setdefault(self.names[column], []).append(place)

    def beside(self, members: Iterable[int]) -> Beside:
        """Return what is left beside a set."""
        key = frozenset(members)
        if key not in self.known:
            if len(self.known) > 12:  # each holds all columns
                self.known.pop(next(iter(self.known)))
            self.known[key] = Beside(self, tuple(sorted(key)))
        return self.known[key]

    def evidence(self, members: Iterable[int]) -> float:
        """Return the log posterior odds of a set against none of it, with every law exact."""
        chosen = sorted(members)
        if not chosen:
            return 0.0
        beside = self.beside(())
        gram, score = beside.products(chosen)
        odds = sum(self.odds(single, chosen[:number]) for number, single in enumerate(chosen))
        everyday = beside.everyday({self.terms[single].key for single in chosen})
        return float(log_evidence(gram, score, LARGEST)) - everyday + odds

    def redrawn(self, members: Iterable[int], draws: Array) -> Array:
        """Return by how much likelier a set is against none of it, (n,), with stretches drawn anew.

        Args:
            members: The set.
            draws: How often each stretch is drawn, `(n, stretches)`.
        """
        columns = [at for single in sorted(members) for at in self.columns(single)]
        if not columns:
            return np.zeros(len(draws))
        beside = self.beside(())
        gram, score = products_by_group(self.stretch, beside.columns(columns), beside.residual)
        drawn = log_evidence(np.tensordot(draws, gram, 1), draws @ score, LARGEST)
        return drawn - log_evidence(gram.sum(axis=0), score.sum(axis=0), LARGEST)

    def bar(self, candidates: Iterable[int]) -> None:
        """Let candidates be none any more."""
        for single in candidates:
            self.terms[single] = replace(self.terms[single], odds=NOTHING)
        self.known.clear()

    def odds(self, single: int, members: Iterable[int]) -> float:
        """Return the log prior odds of a candidate beside a set.

        Whoever has not calibrated one of a truck's numbers has not calibrated the others, and a floor on
        which a wheel met two bumps has more of them.
        """
        term = self.terms[single]
        if term.effect == "bump" and len(term.fixed["times"]) == 1:
            others = [self.terms[other] for other in members if other != single]
            bumps = sum(len(other.fixed["times"]) for other in others if other.key == term.key)
            if bumps >= MANY:
                return max(term.odds, AGAIN)
        if term.effect in NUMBERS and any(
            self.terms[other].effect in NUMBERS
            and self.terms[other].component.startswith(term.component[:1])
            and self.terms[other].key != term.key
            for other in members
        ):
            return term.odds + math.log(UNCALIBRATED / NUMBER)
        return term.odds

    def same(self, keys: set[tuple[str, str]]) -> tuple[NDArray[np.int64], Array]:
        """Return the everyday columns of what has one of some names, and their sizes."""
        everyday, sizes = self.everyday
        mine = [place for key in sorted(keys) for place in self.called.get(key, ())]
        return everyday[mine], sizes[mine]

    def columns(self, single: int) -> range:
        """Return the columns of a candidate."""
        return range(self.places[single].start, self.places[single].stop)


class Beside:
    """What is left of the data and of all candidates beside a set of members.

    Attributes:
        nuisance: Members and everyday sizes, which are noise to all others, whitened, `(V, n)`.
        residual: What is left of the data, `(V,)`.
    """

    def __init__(self, posterior: Posterior, members: tuple[int, ...]) -> None:
        self.posterior, self.members = posterior, members
        self.known: dict[int, float] = {}
        self.loosening: csr_array | None = None
        white = posterior.regression.white
        data = white[:, 0] + posterior.shift
        if members:
            part = self._discrepancy(data)
            if float((part**2).sum()) > 1.0:
                self.weight = self._weight(part)
                self.loosening = loosening(part * self.weight, posterior.stretch)
        everyday, usual = posterior.everyday
        own = [at for single in members for at in posterior.columns(single)]
        sizes = np.concatenate((usual, np.full(len(own), LARGEST)))
        self.nuisance = self._loosened(white[:, [*everyday, *own]]) * sizes
        self.inside = self.nuisance.T @ self.nuisance
        self.shrunk = shrinking(self.inside)
        self.residual = self.free(data[:, None])[:, 0]
        self._sizes = self._held_by(self._loosened(data[:, None]))[:, 0]
        self._most = np.array(
            [posterior.terms[single].most for single in members for _ in posterior.columns(single)]
        )

    @cached_property
    def _white(self) -> Array:
        """All columns, the data first, with members being noise where their laws are not exact, `(V, C)`."""
        return self._loosened(self.posterior.regression.white)

    @cached_property
    def _taken(self) -> tuple[Array, Array]:
        """What all columns share with the nuisances (n, C), and what is taken of them for it (n, C)."""
        shared = self.nuisance.T @ self._white
        return shared, self.shrunk @ shared

    def left(self, columns: Sequence[int] | NDArray[np.int64]) -> tuple[Array, Array]:
        """Return products of what is left of some columns with each other (k, k), and with the data (k,)."""
        shared, taken = (part[:, columns] for part in self._taken)
        return self._products(self._white[:, columns], shared, taken)

    def columns(self, columns: Sequence[int] | NDArray[np.int64]) -> Array:
        """Return what is left of some columns, `(V, k)`."""
        return self.free(self.posterior.regression.white[:, columns])

    def _loosened(self, rows: Array) -> Array:
        """Return rows (V, C) whitened anew, members being noise where their laws are not exact."""
        return rows if self.loosening is None else loosened(rows * self.weight, self.loosening)

    def _held_by(self, rows: Array) -> Array:
        """Return what of whitened rows (V, k) the members hold, in their coefficients, `(n, k)`."""
        if not self.members:
            return np.zeros((0, rows.shape[1]))
        return np.asarray(self._holding @ (self.nuisance.T @ rows))

    @cached_property
    def _holding(self) -> Array:
        """What the members hold of products (n,) of rows with nuisances, in their coefficients, `(k, n)`."""
        count = len(self.posterior.everyday[0])
        return np.asarray(LARGEST * np.linalg.inv(self.inside + np.eye(len(self.inside)))[count:])

    def _discrepancy(self, data: Array) -> Array:
        """Return what members may do otherwise than their laws say, `(V, k)`."""
        terms, white = self.posterior.terms, self.posterior.regression.white
        columns = white[:, [at for single in self.members for at in self.posterior.columns(single)]]
        precision = columns.T @ columns + np.eye(columns.shape[1]) / LARGEST**2
        sizes = np.linalg.solve(precision, columns.T @ data)
        parts, first = [], 0
        for single in self.members:
            here = slice(first, first + len(self.posterior.columns(single)))
            parts.append(terms[single].inexact * columns[:, here] @ sizes[here])
            first = here.stop
        return np.stack(parts, axis=1)

    def _cancels(self, with_it: Array) -> bool:
        """Say whether a candidate makes members absurdly large, which it then nearly cancels.

        Such a pair would be believed for what the two laws, neither exact, leave of each other.

        Args:
            with_it: Sizes of the members beside the candidate, `(n,)`.
        """
        sizes = np.abs(with_it)
        grown = (sizes > GROWN * np.abs(self._sizes)) & (sizes > CANCELLING)
        return bool(np.any(grown & np.isfinite(self._most)))

    def _rarer(self, with_it: Array) -> float:
        """Return by how much members are less likely a priori at the sizes that a candidate drives them to.

        Members are integrated out with one wide normal prior; that of faults has two parts.

        Args:
            with_it: Sizes of the members beside the candidate, `(n,)`.
        """
        return min(0.0, float((_density(with_it) - _density(self._sizes)).sum()))

    def _weight(self, part: Array) -> Array:
        """Return the weights (V, 1) of rows: where members are strong, their shapes are not exact."""
        second = self.posterior.second
        power = (part**2).sum(axis=1)
        count = np.maximum(np.bincount(second), 1)
        mean = np.bincount(second, weights=power) / count
        return np.asarray(1.0 / np.sqrt(1.0 + mean[second]))[:, None]

    def strength(self, added: Array) -> Array:
        """Return by how many sigma (C,) each of added columns (V, C) would be estimated, signed."""
        gram, score = self.scores(added)
        return np.asarray(score / np.sqrt(np.maximum(np.diagonal(gram), 1e-12)))

    def free(self, added: Array) -> Array:
        """Return added columns (V, C) as what is left of them."""
        return free(self._loosened(added), self.nuisance, self.shrunk)

    def scores(self, added: Array) -> tuple[Array, Array]:
        """Return products of added columns (V, C) with each other (C, C), and with the data (C,)."""
        added = self._loosened(added)
        shared = self.nuisance.T @ added
        return self._products(added, shared, self.shrunk @ shared)

    def _products(self, columns: Array, shared: Array, taken: Array) -> tuple[Array, Array]:
        """Return products of what is left of columns (V, k) with each other (k, k), and with the data (k,).

        Args:
            columns: With members being noise.
            shared: Their products with the nuisances, `(n, k)`.
            taken: What of the nuisances is taken away of them, `(n, k)`.
        """
        score = self.residual @ columns - (self.residual @ self.nuisance) @ taken
        across = shared.T @ taken
        return columns.T @ columns - across - across.T + taken.T @ self.inside @ taken, score

    def products(self, candidates: Sequence[int]) -> tuple[Array, Array]:
        """Return products of candidates' columns with each other (k, k) and with the data (k,).

        They are for a robot without any everyday size of what the candidates are called.
        """
        posterior = self.posterior
        columns = [at for single in candidates for at in posterior.columns(single)]
        same, sizes = posterior.same({posterior.terms[single].key for single in candidates})
        gram, score = self.left([*columns, *same])
        if not len(same):
            return gram, score
        count = len(columns)
        both = np.column_stack([score, gram])
        shared = sizes[:, None] * both[count:, : count + 1]
        inside = sizes[:, None] * gram[count:, count:] * sizes
        more = shared.T @ np.linalg.solve((1.0 + 1e-9) * np.eye(len(same)) - inside, shared)
        return gram[:count, :count] + more[1:, 1:], score[:count] + more[1:, 0]

    def everyday(self, keys: set[tuple[str, str]], spread: float = 1.0) -> float:
        """Return the log Bayes factor of the everyday sizes of some names against none of them.

        Args:
            keys: Effects and components.
            spread: Factor by which squares of noise are larger than they should be.
        """
        same, sizes = self.posterior.same(keys)
        if not len(same):
            return 0.0
        if "_taken" in self.__dict__:
            inside, score = self.left(same)
        else:  # a judgement of one candidate needs no other column
            inside, score = self.scores(self.posterior.regression.white[:, same])
        away = np.linalg.inv((1.0 + 1e-9) * np.eye(len(same)) - sizes[:, None] * inside * sizes)
        score = away @ (sizes * score)
        return float(log_evidence((away - np.eye(len(same))) / spread, score / spread, 1.0))

    def quick(self, single: int) -> float:
        """Return a candidate's log posterior odds if noise is white and its law holds everywhere."""
        if single not in self.known:
            self.known[single] = self._quick(single)
        return self.known[single]

    def _quick(self, single: int) -> float:
        term = self.posterior.terms[single]
        gram, score = self.products([single])
        if term.positive and np.any(score < 0.0):
            return NOTHING
        odds = self.posterior.odds(single, self.members)
        supported = float(bayes_factor(gram, score)) - self.everyday({term.key})
        return odds + supported - _ordinary(term, gram, score)

    def judge(self, single: int) -> Judgement:
        """Return what a candidate is worth, against a robot that has an everyday size of it."""
        columns = list(self.posterior.columns(single))
        term = self.posterior.terms[single]
        own, residual = self._apart(columns, term.key)
        gram, score = own.T @ own, own.T @ residual
        size = np.eye(len(columns)) / LARGEST**2
        fitted: Array = np.asarray(np.linalg.solve(gram + size, score), np.float64)
        lasting = term.effect == "unknown" and not term.is_local
        quiet = lasting and float(fitted @ gram @ fitted) < SEEN * len(residual)
        held = self._held_by(self._loosened(self.posterior.regression.white[:, columns]))
        with_it = self._sizes - held @ fitted
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
        if (term.positive and np.any(coefficients < 0.0)) or absurd:
            evidence = NOTHING
        folds = self._by_fold(own, residual)
        gained = earned(*folds, spread) + loose / spread if evidence > NOTHING else NOTHING
        if gained > 0.0 and not term.is_local:
            gain = residual**2 - after**2
            outlying = self._outlying(gain)
            if gain @ outlying > CONCENTRATED * gain.sum():
                gained = min(gained, earned(*products_by_group(outlying, own, residual), spread))
        odds = self.posterior.odds(single, self.members)
        prior = odds + self._rarer(with_it)
        least, support = min(evidence, gained), NOTHING
        if least > NOTHING:
            support = min(white, gained if spread == 1.0 else earned(*folds, 1.0) + loose)
        rank = prior + support
        return Judgement(prior + least, evidence, gained, coefficients, covariance, spread, rank, support)

    def _apart(self, columns: Sequence[int], key: tuple[str, str]) -> tuple[Array, Array]:
        """Return columns (V, k) and data (V,) for a robot without any everyday size of what has a name."""
        same, sizes = self.posterior.same({key})
        rows = np.column_stack([self.residual, self.columns(columns)])
        if len(same):
            rows = narrowed(rows, self.columns(same) * sizes)
        return rows[:, 1:], rows[:, 0]

    def redrawn(self, single: int, draws: Array) -> Array:
        """Return by how much more a candidate is supported, (n,), with stretches drawn anew.

        Args:
            single: The candidate.
            draws: How often each stretch is drawn, `(n, stretches)`.
        """
        term = self.posterior.terms[single]
        own, residual = self._apart(list(self.posterior.columns(single)), term.key)
        gram, score = products_by_group(self.posterior.stretch, own, residual)
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
        stretch = self.posterior.stretch
        count = int(stretch.max()) + 1
        scores = np.stack(
            [np.bincount(stretch, weights=column * after, minlength=count) for column in own.T], axis=1
        )
        inside = np.bincount(stretch, weights=(own**2).sum(axis=1), minlength=count)
        told = float(inside.sum() ** 2 / max((inside**2).sum(), 1e-300))  # stretches that tell anything
        inverse = np.linalg.inv(gram + 1e-9 * np.eye(len(gram)))
        ratio = float(np.einsum("bi,ij,bj->", scores, inverse, scores)) / len(gram)
        ratio *= told / max(told - 1.0, 1.0)
        power = (own**2).sum(axis=1)
        uneven = float(power @ after**2 / max(power.sum(), 1e-300))
        return max(1.0, uneven, (KNOWN + told * ratio) / (KNOWN + told))

    def _outlying(self, gain: Array) -> NDArray[np.int64]:
        """Return which rows (V,) are of the few seconds in which most is gained, of gains (V,) of each."""
        moment = self.posterior.moment
        gains = np.bincount(moment, weights=gain)
        return np.isin(moment, np.argsort(-gains)[:MOMENTS]).astype(np.int64)

    def _by_fold(self, own: Array, residual: Array) -> tuple[Array, Array]:
        """Return products of columns (V, k) with each other (F, k, k) and the data (F, k), in each fold."""
        inside = np.bincount(self.posterior.fold, weights=(own**2).sum(axis=1))
        fold = self.posterior.fold
        if inside.max() > CONCENTRATED * inside.sum():
            fold = self.posterior.moments
        return products_by_group(fold, own, residual)


def products_by_group(group: NDArray[np.int64], columns: Array, data: Array) -> tuple[Array, Array]:
    """Return products of columns (V, k) with each other (G, k, k) and the data (G, k), in each group of rows.

    Args:
        group: Number of each row's group, `(V,)`.
        columns: The columns.
        data: The data, `(V,)`.
    """
    count, width = int(group.max()) + 1, columns.shape[1]
    gram, score = np.empty((count, width, width)), np.empty((count, width))
    for first in range(width):
        score[:, first] = np.bincount(group, weights=columns[:, first] * data, minlength=count)
        for other in range(first, width):
            inside = np.bincount(group, weights=columns[:, first] * columns[:, other], minlength=count)
            gram[:, first, other] = gram[:, other, first] = inside
    return gram, score


def earned(gram: Array, score: Array, spread: float) -> float:
    """Return the gain in log predictive density of folds that are held out in turn.

    Args:
        gram: Products of columns with each other in each fold, `(F, k, k)`.
        score: Products with the data, `(F, k)`.
        spread: Factor by which squares of noise are larger than they should be.
    """
    prior = np.eye(gram.shape[-1]) / LARGEST**2
    others = (score.sum(axis=0) - score) / spread
    before = prior + (gram.sum(axis=0) - gram) / spread
    every, after = score.sum(axis=0) / spread, prior + gram.sum(axis=0) / spread
    known = (others * np.linalg.solve(before, others[..., None])[..., 0]).sum(axis=-1)
    gain = every @ np.linalg.solve(after, every) - np.linalg.slogdet(after)[1]
    return 0.5 * float((gain - known + np.linalg.slogdet(before)[1]).sum())


def _ordinary(term: Term, gram: Array, score: Array) -> float:
    """Return the log Bayes factor of what any robot meets of a candidate at some moment, against none."""
    return float(log_evidence(gram, score, term.ordinary)) if term.ordinary > 0.0 else 0.0


def _density(coefficients: Array) -> Array:
    """Return the log prior density of coefficients, over that with which members are integrated out."""
    parts = [math.log(share / size) - 0.5 * (coefficients / size) ** 2 for size, share in TAILS]
    wide = -math.log(LARGEST) - 0.5 * (coefficients / LARGEST) ** 2
    return np.asarray(np.logaddexp.reduce(parts, axis=0) - wide)


def bayes_factor(gram: Array, score: Array) -> Array:
    """Return the log Bayes factor (...) of a fault against none.

    Args:
        gram: Products of its columns with each other, shape `(..., k, k)`.
        score: Products of its columns with the data, shape `(..., k)`.
    """
    parts = [math.log(share) + log_evidence(gram, score, size) for size, share in TAILS]
    return np.asarray(np.logaddexp.reduce(parts, axis=0))


def log_evidence(gram: Array, score: Array, size: float) -> Array:
    """Return the log Bayes factor (...) of coefficients of a normal prior of a size against none."""
    precision = size**2 * gram + np.eye(gram.shape[-1])
    solved = np.linalg.solve(precision, score[..., None])[..., 0]
    determinant = np.linalg.slogdet(precision)[1]
    return np.asarray(0.5 * size**2 * (score * solved).sum(axis=-1) - 0.5 * determinant)


def shrinking(inside: Array) -> Array:
    """Return the matrix S (k, k) by which (1 + N N')^-1/2 = 1 - N S N', of the products N'N of nuisances."""
    sizes, axes = np.linalg.eigh(inside)
    sizes = np.maximum(sizes, 1e-12)
    return np.asarray((axes * ((1.0 - 1.0 / np.sqrt(1.0 + sizes)) / sizes)) @ axes.T)


def free(rows: Array, nuisance: Array, shrunk: Array | None = None) -> Array:
    """Return rows (V, C) whitened anew, nuisances (V, k) of unit size and given `shrinking` being noise."""
    shrunk = shrinking(nuisance.T @ nuisance) if shrunk is None else shrunk
    return np.asarray(rows - nuisance @ (shrunk @ (nuisance.T @ rows)))


def narrowed(rows: Array, nuisance: Array) -> Array:
    """Return rows (V, C) with nuisances (V, k), no longer noise: the inverse of `shrinking`."""
    sizes, axes = np.linalg.eigh(nuisance.T @ nuisance)
    sizes = np.clip(sizes, 1e-12, 1.0 - 1e-9)
    grown = axes * ((1.0 / np.sqrt(1.0 - sizes) - 1.0) / sizes)
    return np.asarray(rows + nuisance @ (grown @ (axes.T @ (nuisance.T @ rows))))


def loosened(rows: Array, by: csr_array) -> Array:
    """Return rows (V, C) whitened anew by what `loosening` gave."""
    return np.asarray(rows - by @ (by.T @ rows))


def loosening(part: Array, stretch: NDArray[np.int64]) -> csr_array:
    """Return B (V, n) by which rows are whitened anew where parts (V, k) are of any size in a stretch.

    The noise of a stretch is then 1 + part part', and its inverse root is 1 - B B'.
    """
    order = np.argsort(stretch, kind="stable")
    edges = np.searchsorted(stretch[order], np.arange(int(stretch.max()) + 2))
    rows, columns, values, count = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)], [np.zeros(0)], 0
    for start, end in itertools.pairwise(edges.tolist()):
        mine = order[start:end]
        if float((part[mine] ** 2).sum()) < 1e-3:
            continue
        axes, sizes, _ = np.linalg.svd(part[mine], full_matrices=False)
        axes = axes * np.sqrt(1.0 - 1.0 / np.sqrt(1.0 + sizes**2))
        rows.append(np.repeat(mine, axes.shape[1]))
        columns.append(np.tile(count + np.arange(axes.shape[1]), len(mine)))
        values.append(axes.ravel())
        count += axes.shape[1]
    where = np.concatenate(rows), np.concatenate(columns)
    return csr_array((np.concatenate(values), where), shape=(len(part), count))
