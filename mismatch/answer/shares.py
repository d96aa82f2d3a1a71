"""How much of what a fit leaves an error explains: from one reading to the next, and open loop.

What hides in the noise from one reading to the next may add up until a robot is lost. What healthy tyres do
adds up, too, and is small against a usual robot on the roughest floor.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.answer.nominal import innovation_variance, roughest_levels
from omnimate.mismatch.answer.rerun import STRETCH
from omnimate.mismatch.candidates.unknown import raw_columns
from omnimate.mismatch.noise.levels import filter_of
from omnimate.mismatch.recording.pose_outliers import MAD_TO_SIGMA

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.recording.response import Columns
    from omnimate.vehicle.se2 import Array

OUTLYING = 4.0  # [standard deviations] at which innovations are cut: single pushes are no pattern


@dataclass(frozen=True, slots=True)
class Share:
    """The channel on which a prediction shows most."""

    channel: str  # its name
    # of the innovations' square in that channel on stretches that are left out, or of the square that noise
    # levels of `nominal` let expect where that is larger: usual ones, open loop the roughest
    share: float
    open_loop: bool = False  # whether innovations are those after `STRETCH`, or from one reading to the next


def largest_share(
    names: Sequence[str],
    channel: NDArray[np.int64],
    data: Array,
    predicted: Array,
    expected: Array,
    *,
    open_loop: bool = False,
) -> Share:
    """Return the channel in which a prediction (R,) of data (R,) lowers their square most.

    `channel` (R,) are the numbers of the rows' channels, and `expected` (R,) is the square that noise
    makes.
    """
    falls = np.bincount(channel, predicted * (2.0 * data - predicted))
    number = int(falls.argmax())
    shown = channel == number
    square = max(float((data[shown] ** 2).sum()), float(expected[shown].sum()))
    return Share(names[number], float(falls[number]) / square, open_loop)


def open_loop_shares(regression: Regression, errors: Mapping[int, Array]) -> dict[int, Share]:
    """Return where errors show most after `STRETCH` without a reading, by number.

    `errors` are of each unknown error the coefficients (V, k) in each row, from stretches without it. What
    effects of the fit explain of an error is theirs.
    """
    if not errors:
        return {}
    pairs = [(windows.thinned(STRETCH), windows) for windows in regression.windows]
    filters = [filter_of(thin, regression.noise) for thin, _ in pairs]
    rows = np.concatenate(
        [np.isfinite(thin.measured)[np.isfinite(windows.measured)] for thin, windows in pairs]
    )
    channel, names = regression.channel[rows], regression.windows[0].names

    def whitened(raw: Sequence[Columns]) -> Array:
        return np.vstack([run.whiten(*columns) for run, columns in zip(filters, raw, strict=True)])

    data = [(inputs[:, :, :1], measured[:, :, :1]) for inputs, measured in regression.raw]
    scale, innovations = scaled(whitened(data)[:, 0], channel)
    expected = innovation_variance(filters, roughest_levels(regression)) / scale**2
    known = [(inputs[:, :, 1:], measured[:, :, 1:]) for inputs, measured in regression.raw]
    effects = regression.whitened(known)
    precision = effects.T @ effects + np.eye(effects.shape[1])
    shares = {}
    for number, raw in raw_columns(regression, errors).items():
        explained = np.linalg.solve(precision, effects.T @ regression.whitened(raw))
        rest = [
            (inputs - pushed @ explained, measured - seen @ explained)
            for (inputs, measured), (pushed, seen) in zip(raw, known, strict=True)
        ]
        predicted = (whitened(rest) * errors[number][rows]).sum(axis=1) / scale
        shares[number] = largest_share(names, channel, innovations, predicted, expected, open_loop=True)
    return shares


def scaled(innovations: Array, channel: NDArray[np.int64]) -> tuple[Array, Array]:
    """Return the scale (R,) of each row's channel, and innovations (R,) in units of it, outliers cut."""
    scale = np.ones(len(innovations))
    for rows in (channel == number for number in np.unique(channel)):
        values = innovations[rows]
        scale[rows] = max(MAD_TO_SIGMA * float(np.median(np.abs(values))), 0.3 * float(values.std()), 1e-9)
    return scale, np.clip(innovations / scale, -OUTLYING, OUTLYING)
