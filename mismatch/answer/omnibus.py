"""Omnibus test of what a fit leaves: does an error without a name, or any quantity of the drive, predict it?

The whitened innovations of all channels are predicted by the columns of each error (`candidates.unknown`),
and those of each channel by each quantity at the same instant, on stretches that are left out in turn. An
error says which component has it; a quantity predicts what no component's error does. The null distribution
is that of the largest gain among all, with innovations that are shifted in a circle against the drive, and
with a random sign in each stretch of time: no predictor can be right then, however the noise is correlated.
Its tail is that of a largest value (Gumbel, Statistics of Extremes, 1958; tails of permutation tests: Winkler
et al., NeuroImage 141, 2016).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects.block import LINKAGE
from omnimate.mismatch.answer.nominal import innovation_variance, usual_levels
from omnimate.mismatch.answer.shares import largest_share, open_loop_shares, scaled
from omnimate.mismatch.candidates.regression import slices_of
from omnimate.mismatch.candidates.terms import Unknown
from omnimate.mismatch.evidence.rows import products_by_group
from omnimate.mismatch.recording.folds import folds_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from numpy.typing import NDArray

    from omnimate.mismatch.answer.shares import Share
    from omnimate.mismatch.candidates.unknown import UnknownErrors
    from omnimate.mismatch.evidence.posterior import Posterior
    from omnimate.vehicle.se2 import Array

DRAWS = 99  # of the null: the scale of its tail is then known to a tenth
ERROR_RATE = 1e-3  # declared: one healthy recording in a thousand is said to leave something
# Declared share of an error (not of its square) below which a mismatch is a trace: a twentieth.
RELEVANT = 0.05
RELEVANT_SQUARE = 1.0 - (1.0 - RELEVANT) ** 2  # share of a square that goes with that share of an error
SHORTEST = 0.05  # share of a recording by which innovations are shifted at least
SHOWN = 6  # predictions that are kept, at most
BATCH = 32  # errors whose columns are in memory at once


@dataclass(frozen=True, slots=True)
class Prediction:
    """What predicts what is left where no fit has seen it: an error without a name, or a quantity."""

    component: str  # component that has the error; of a quantity, the sensor of the channel
    quantity: str  # on which it depends
    shown: Share  # where it shows most
    gain: float  # fall of the chi-square of all channels there
    columns: Array  # what predicts it, in all rows of the regression, `(V, k)`


@dataclass(frozen=True, slots=True)
class Leftover:
    """What a fit leaves that can be predicted."""

    p_value: float  # probability of so strong a prediction where nothing can be predicted
    predictions: tuple[Prediction, ...] = ()  # those beyond the largest of the null, strongest first

    @property
    def strongest(self) -> Prediction | None:
        """The prediction of the largest share."""
        return max(self.predictions, key=lambda prediction: prediction.shown.share, default=None)

    @property
    def relevant(self) -> bool:
        """Whether something predicts a share of a channel that is no trace."""
        return self.strongest is not None and self.strongest.shown.share >= RELEVANT_SQUARE

    @property
    def probability(self) -> float:
        """Probability that something is left, from the largest Bayes factor that a p-value can mean.

        It is 1 / (-e p ln p) (Sellke, Bayarri & Berger, American Statistician 55, 2001).
        """
        if not 0.0 < self.p_value < math.exp(-1.0):
            return 1.0 if self.p_value == 0.0 else 0.0
        odds = math.exp(Unknown.prior.log_odds) / (-math.e * self.p_value * math.log(self.p_value))
        return odds / (1.0 + odds)

    def project_out(self, rows: Array) -> Array:
        """Return rows (V, C) without what the predictions' columns explain of them."""
        if not self.predictions:
            return rows
        axes, sizes, _ = np.linalg.svd(
            np.hstack([prediction.columns for prediction in self.predictions]), full_matrices=False
        )
        axes = axes[:, sizes > 1e-8 * sizes[0]]
        return np.asarray(rows - axes @ (axes.T @ rows))


@dataclass(frozen=True, slots=True)
class _Predictors:
    """Groups of columns in some rows, each of which may predict what is left there."""

    names: list[tuple[str, str]]  # component and quantity of each
    widths: list[int]  # number of columns of each
    rows: NDArray[np.int64]  # the rows, `(R,)`
    columns: Callable[[slice], Array]  # some of the columns in these rows, in units of the data, `(R, k)`

    def heldout_gains(self, data: Array, fold: NDArray[np.int64]) -> Array:
        """Return by how much (n, B) each of n lowers the square of data (V, B) in folds (V,) left out."""
        data_of_rows, fold_of_rows = data[self.rows], fold[self.rows]
        folds = [np.flatnonzero(fold_of_rows == number) for number in range(int(fold.max()) + 1)]
        data_of_fold = [data_of_rows[rows] for rows in folds]
        all_places, gains = slices_of(self.widths), []
        for first in range(0, len(all_places), BATCH):
            places = all_places[first : first + BATCH]
            start = places[0].start
            columns = self.columns(slice(start, places[-1].stop))
            parts = [columns[rows] for rows in folds]
            products = np.stack([part.T @ data for part, data in zip(parts, data_of_fold, strict=True)])
            for place in (slice(group.start - start, group.stop - start) for group in places):
                gram = np.stack([part[:, place].T @ part[:, place] for part in parts])
                score = products[:, place]
                fitted = _without_fold(gram, score)
                gains.append((2.0 * fitted * score - fitted * (gram @ fitted)).sum(axis=(0, 1)))
        return np.array(gains)


def leftover(posterior: Posterior, unknown: UnknownErrors, members: Iterable[int]) -> Leftover:
    """Return what of errors and quantities predicts the innovations that a set of candidates leaves.

    What every robot has a little of, and members' discrepancies from their laws, are noise there.
    """
    regression, conditional = posterior.regression, posterior.given(members)
    names = regression.windows[0].names
    scale, data = _data_and_null(conditional.residual, regression.channel, posterior.candidates.stretch)
    fold = np.unique(regression.of_rows(folds_of(regression.windows)), return_inverse=True)[1]
    predictors = [
        _Predictors(
            [(term.component, term.fixed["quantity"]) for term in unknown.terms],
            unknown.widths,
            np.arange(len(data)),
            lambda part: np.asarray(conditional.project_out(unknown.columns[:, part]) / scale[:, None]),
        ),
        *(
            _of_channel(unknown, np.flatnonzero(regression.channel == number), names[number])
            for number in np.unique(regression.channel)
        ),
    ]
    gain = np.concatenate([predictor.heldout_gains(data, fold) for predictor in predictors])
    largest = gain.max(axis=0)
    p_value = _tail(float(largest[0]), largest[1:])
    if p_value >= ERROR_RATE:
        return Leftover(p_value)
    expected = innovation_variance(regression.filters, usual_levels(regression)) / scale**2
    beyond = np.flatnonzero(gain[:, 0] > largest[1:].max())
    errors = beyond[beyond < len(unknown.terms)]
    strongest = errors if len(errors) else beyond
    strongest = strongest[np.argsort(-gain[strongest, 0])][:SHOWN]
    numbered = [(predictor, number) for predictor in predictors for number in range(len(predictor.widths))]
    predictions, sizes_of_errors = {}, {}
    for at in strongest.tolist():
        predictor, number = numbered[at]
        rows = predictor.rows
        columns, channel = np.zeros((len(data), predictor.widths[number])), regression.channel[rows]
        columns[rows] = part = predictor.columns(slices_of(predictor.widths)[number])
        gram, products = products_by_group(fold[rows], part, data[rows, 0])
        sizes = _without_fold(gram, products[:, :, None])[fold[rows], :, 0]
        predicted = (part * sizes).sum(axis=1)
        shown = largest_share(names, channel, data[rows, 0], predicted, expected[rows])
        component, quantity = predictor.names[number]
        fall, in_units = float(gain[at, 0]), columns * scale[:, None]
        predictions[at] = Prediction(component, quantity, shown, fall, in_units)
        if at < len(unknown.terms):
            sizes_of_errors[at] = sizes
    for at, shown in open_loop_shares(regression, sizes_of_errors).items():
        if shown.share > predictions[at].shown.share:
            predictions[at] = replace(predictions[at], shown=shown)
    return Leftover(p_value, tuple(predictions.values()))


def _of_channel(unknown: UnknownErrors, rows: NDArray[np.int64], channel: str) -> _Predictors:
    """Return the quantities of the drive at the instants of a channel's rows, as its predictors."""
    component, curves = channel if channel in LINKAGE else "poses", unknown.curves[rows]
    curves = curves - curves.mean(axis=0)
    names = [(component, quantity) for quantity in unknown.quantities]
    return _Predictors(names, list(unknown.quantities.values()), rows, lambda part: curves[:, part])


def _data_and_null(
    innovations: Array, channel: NDArray[np.int64], stretch: NDArray[np.int64]
) -> tuple[Array, Array]:
    """Return the scale (V,) of each row's channel, and scaled innovations `(V, 1 + DRAWS)`, the null's last.

    The null's are shifted in a circle, channel by channel, and their signs are drawn for each stretch.
    """
    chance = np.random.default_rng(0)
    scale, cut = scaled(innovations, channel)
    data = np.empty((len(innovations), 1 + DRAWS))
    for rows in (np.flatnonzero(channel == number) for number in np.unique(channel)):
        values = cut[rows]
        sign = chance.choice([-1.0, 1.0], size=(int(stretch.max()) + 1, DRAWS))
        least = int(SHORTEST * len(values))
        shifts = chance.integers(least, len(values) - least, size=DRAWS)
        data[rows, 0] = values
        data[rows, 1:] = np.stack([np.roll(values, shift) for shift in shifts], axis=1) * sign[stretch[rows]]
    return scale, data


def _without_fold(gram: Array, score: Array) -> Array:
    """Return fits (F, k, B) without each fold, by the error's prior, of products (F, k, k) and (F, k, B)."""
    precision = gram.sum(axis=0) - gram + np.eye(gram.shape[1])
    return np.asarray(np.linalg.solve(precision, score.sum(axis=0) - score))


def _tail(value: float, largest: Array) -> float:
    """Return the probability of a value or more, of which largest values (n,) were drawn."""
    scale = float(largest.std()) * math.sqrt(6.0) / math.pi
    middle = float(largest.mean()) - np.euler_gamma * scale
    return float(-np.expm1(-np.exp(-(value - middle) / max(scale, 1e-9))))
