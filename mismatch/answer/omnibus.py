"""Omnibus test of what a fit leaves: does anything that is known of the drive predict it?

Of each channel the whitened innovations are predicted from each quantity of the drive, now and one window
before, on stretches that are left out in turn. The null distribution is that of the largest gain among all
channels and quantities, with innovations that are shifted in a circle against the drive, and whose sign is
drawn anew in each stretch of time: no predictor can be right then, whatever the colour of the noise. Its tail
is that of a largest value (Gumbel, Statistics of Extremes, 1958; tails of permutation tests: Winkler et al.,
NeuroImage 141, 2016).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.answer.where import row_names
from omnimate.mismatch.candidates.quantities import shared_quantities
from omnimate.mismatch.candidates.regression import slices_of
from omnimate.mismatch.candidates.terms import UNKNOWN_PRIOR
from omnimate.mismatch.recording.folds import folds_of
from omnimate.mismatch.recording.pose_outliers import MAD_TO_SIGMA

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.evidence.posterior import Posterior
    from omnimate.vehicle.se2 import Array

DRAWS = 99  # of the null: the scale of its tail is then known to a tenth
ERROR_RATE = 1e-3  # declared: one healthy recording in a thousand is said to leave something
RELEVANT = (
    0.05  # declared share of an error (not of its square) below which a mismatch is a trace: a twentieth
)
OUTLYING = 4.0  # [standard deviations] at which innovations are cut: single pushes are no pattern
SHORTEST = 0.05  # share of a recording by which innovations are shifted at least
FEWEST_ROWS = 60  # of a channel, to which eight stretches with some coefficients can be fitted
RIDGE = 0.02  # prior precision of coefficients, in columns' squares: a fold of fifty tells as much
SHOWN = 6  # predictions that are kept, at most


@dataclass(frozen=True, slots=True)
class Prediction:
    """A channel that a quantity of the drive predicts where no fit has seen it.

    Attributes:
        channel: Name of the channel.
        quantity: On which it depends.
        share: Of the innovations' square in that channel, or of the expected noise's where that is larger, on
            stretches that are left out.
        gain: The same, as a fall of the chi-square.
        columns: What predicts it, in all rows of the regression, `(V, k)`.
    """

    channel: str
    quantity: str
    share: float
    gain: float
    columns: Array


@dataclass(frozen=True, slots=True)
class Leftover:
    """What a fit leaves that can be predicted.

    Attributes:
        p_value: Probability of so strong a prediction where nothing can be predicted.
        predictions: Those beyond the largest of the null, the strongest first; empty without significance.
    """

    p_value: float
    predictions: tuple[Prediction, ...] = ()

    @property
    def relevant(self) -> bool:
        """Whether something predicts a share of a channel that is no trace."""
        return any(prediction.share >= 1.0 - (1.0 - RELEVANT) ** 2 for prediction in self.predictions)

    @property
    def probability(self) -> float:
        """Probability that something is left, from the largest Bayes factor that a p-value can mean.

        It is 1 / (-e p ln p) (Sellke, Bayarri & Berger, American Statistician 55, 2001).
        """
        if not 0.0 < self.p_value < math.exp(-1.0):
            return 1.0 if self.p_value == 0.0 else 0.0
        odds = math.exp(UNKNOWN_PRIOR.log_odds) / (-math.e * self.p_value * math.log(self.p_value))
        return odds / (1.0 + odds)

    def project_out(self, rows: Array) -> Array:
        """Return rows (V, C) without what the predictions' columns explain of them."""
        if not self.predictions:
            return rows
        axes, sizes, _ = np.linalg.svd(
            np.hstack([each.columns for each in self.predictions]), full_matrices=False
        )
        axes = axes[:, sizes > 1e-8 * sizes[0]]
        return np.asarray(rows - axes @ (axes.T @ rows))


def leftover(posterior: Posterior, members: Iterable[int]) -> Leftover:
    """Return what predicts the innovations that a set of candidates leaves.

    What every robot has a little of, and members' discrepancies from their laws, are noise there.
    """
    regression, stretch = posterior.regression, posterior.candidates.stretch
    innovations = posterior.given(members).residual
    names = row_names(regression.windows[0])
    curves = shared_quantities([windows.signals for windows in regression.windows])
    stacked = [np.stack([curve for own in drive.values() for curve in own], axis=1) for drive in curves]
    widths = [len(own) for own in curves[0].values()]
    folds = regression.of_rows(folds_of(regression.windows))
    chance = np.random.default_rng(0)
    found, gains = [], []
    for channel in np.unique(regression.channel):
        mine = np.flatnonzero(regression.channel == channel)
        if len(mine) < FEWEST_ROWS:
            continue
        columns = _now_and_before(regression, mine, stacked, widths)
        own = innovations[mine]
        scale = max(MAD_TO_SIGMA * float(np.median(np.abs(own))), 0.3 * float(own.std()), 1e-9)
        own = np.clip(own / scale, -OUTLYING, OUTLYING)
        data = np.column_stack([own, _null(own, stretch[mine], chance)])
        square = max(float(own @ own), len(own) / scale**2)
        for name, part in zip(curves[0], slices_of(2 * width for width in widths), strict=True):
            gains.append(_heldout_gain(columns[:, part], data, folds[mine]))
            found.append((names[channel], name, square, mine, columns[:, part]))
    if not gains:
        return Leftover(1.0)
    gain = np.array(gains)
    null = gain[:, 1:]
    score = (gain - null.mean(axis=1, keepdims=True)) / (null.std(axis=1, keepdims=True) + 1.0)
    largest = score.max(axis=0)
    p_value = _tail(float(largest[0]), largest[1:])
    if p_value >= ERROR_RATE:
        return Leftover(p_value)
    predictions = []
    for number in np.argsort(-score[:, 0])[:SHOWN]:
        channel, name, square, mine, columns = found[number]
        if score[number, 0] > largest[1:].max():
            everywhere = np.zeros((len(innovations), columns.shape[1]))
            everywhere[mine] = columns
            fall = float(gain[number, 0])
            predictions.append(Prediction(channel, name, fall / square, fall, everywhere))
    return Leftover(p_value, tuple(predictions))


def _now_and_before(
    regression: Regression, mine: NDArray[np.int64], curves: list[Array], widths: list[int]
) -> Array:
    """Return curves at the ends of windows of some rows (V,), each with its change since the last window."""
    owner, moment = regression.owner[mine], regression.moment[mine]
    now, before = [], []
    for number, (windows, own) in enumerate(zip(regression.windows, curves, strict=True)):
        at, at_ends = moment[owner == number], windows.at_ends(own)
        now.append(at_ends[at])
        before.append(at_ends[np.maximum(at - 1, 0)])
    there = np.concatenate(now)
    change = there - np.concatenate(before)
    columns = np.hstack([np.hstack([there[:, part], change[:, part]]) for part in slices_of(widths)])
    return np.asarray(columns - columns.mean(axis=0))


def _null(own: Array, stretch: NDArray[np.int64], chance: np.random.Generator) -> Array:
    """Return innovations (V, DRAWS) that are shifted in a circle, with signs drawn for each stretch."""
    sign = chance.choice([-1.0, 1.0], size=(int(stretch.max()) + 1, DRAWS))
    least = int(SHORTEST * len(own))
    shifts = chance.integers(least, len(own) - least, size=DRAWS)
    return np.asarray(np.stack([np.roll(own, shift) for shift in shifts], axis=1) * sign[stretch])


def _heldout_gain(columns: Array, data: Array, fold: NDArray[np.int64]) -> Array:
    """Return by how much columns (V, k) lower the square of each of B data (V, B) where they are left out."""
    groups = [np.flatnonzero(fold == number) for number in np.unique(fold)]
    gram = np.stack([columns[group].T @ columns[group] for group in groups])
    score = np.stack([columns[group].T @ data[group] for group in groups])
    total = gram.sum(axis=0)
    ridge = np.diag(RIDGE * np.diagonal(total) + 1e-9)
    fitted = np.linalg.solve(total - gram + ridge, score.sum(axis=0) - score)
    return np.asarray((2.0 * fitted * score - fitted * (gram @ fitted)).sum(axis=(0, 1)))


def _tail(value: float, largest: Array) -> float:
    """Return the probability of a value or more, of which largest values (n,) were drawn."""
    scale = float(largest.std()) * math.sqrt(6.0) / math.pi
    middle = float(largest.mean()) - np.euler_gamma * scale
    return float(-np.expm1(-np.exp(-(value - middle) / max(scale, 1e-9))))
