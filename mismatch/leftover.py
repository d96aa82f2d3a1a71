"""What a set of effects leaves of recordings, and what would stand out of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.whitening import adjoint

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from omnimate.mismatch.choose import Choice, Set
    from omnimate.mismatch.regression import Regression
    from omnimate.mismatch.windows import Windows
    from omnimate.vehicle.parameters import Channel
    from omnimate.vehicle.se2 import Array

EVENT = 4.0  # sigma from which one window among a thousand is worth a look
NEAR = 1.0  # [s] about an event, in which no other is looked for
_CHUNK = 128

Build = Callable[[int, "Windows", range], "Array"]


@dataclass(frozen=True, slots=True)
class Leftover:
    """What a set of terms leaves.

    Attributes:
        rows: (V,) whitened residual.
        columns: (V, k) whitened columns of the set.
        inverse: (k, k) inverse of their products, with the prior.
        events: of each wheel, moments [s] at which the set already has a bump.
    """

    rows: Array
    columns: Array
    inverse: Array
    events: dict[str, tuple[float, ...]]

    def strength(self, added: Array) -> Array:
        """Return by how many sigma (C,) each of added columns (V, C) would be estimated, signed."""
        shared = self.columns.T @ added
        free = np.einsum("vc,vc->c", added, added) - np.einsum("kc,kl,lc->c", shared, self.inverse, shared)
        return np.asarray((self.rows @ added) / np.sqrt(np.maximum(free, 1e-12)))


def leftover(regression: Regression, choice: Choice, chosen: Set) -> Leftover:
    """Return what a set of terms leaves of a recording."""
    columns = choice.columns(chosen)
    coefficients, covariance = choice.solved(chosen)
    own = regression.white[:, columns]
    bumps = [choice.terms[one] for one in chosen if choice.terms[one].effect == "bump"]
    events = {one.component: one.fixed["times"] for one in bumps}
    return Leftover(regression.white[:, 0] - own @ coefficients, own, covariance / choice.spread, events)


def shocks(regression: Regression, left: Leftover) -> list[tuple[Array, Array]]:
    """Return of each recording the scores `(M, n)` and informations `(M, n, n)` of a push in each window."""
    answers = []
    for number, (windows, run) in enumerate(zip(regression.windows, regression.filters, strict=True)):
        white = np.full(run.spread.shape, np.nan)
        mine = regression.owner == number
        white[regression.moment[mine], regression.channel[mine]] = left.rows[mine]
        answers.append(adjoint(run.transition, windows.observe, run.gains, run.spread, white))
    return answers


def quiet(windows: Windows, left: Leftover) -> Array:
    """Return 1.0 for windows `(M,)` away from known events, whose shape is never met exactly, else 0.0."""
    middle = 0.5 * (windows.time[1:] + windows.time[:-1])
    near = np.zeros(len(middle), bool)
    for moments in left.events.values():
        for moment in moments:
            near |= np.abs(middle - moment) < NEAR
    return np.where(near, 0.0, 1.0)


def lost_way(windows: Windows, scores: Array, informations: Array) -> tuple[Array, Array]:
    """Return the way (M, W) that each wheel lost in each window [m], and by how many sigma."""
    rolled = np.add.reduceat(windows.signals.block.travel, windows.ends[:-1], axis=0)
    lever = -np.sign(rolled)[:, :, None] * windows.lever
    score = np.einsum("mwn,mn->mw", lever, scores)
    information = np.einsum("mwi,mij,mwj->mw", lever, informations, lever)
    sure = information > 0.0
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(sure, score / information, 0.0), np.where(sure, score / np.sqrt(information), 0.0)


def apart(high: NDArray[np.int64], sigmas: Array) -> list[int]:
    """Return the strongest of windows that lie next to each other."""
    chosen: list[int] = []
    for window in sorted(high.tolist(), key=lambda one: -sigmas[one]):
        if all(abs(window - other) > 2 for other in chosen):
            chosen.append(window)
    return chosen


def strengths(regression: Regression, lefts: Sequence[Leftover], build: Build, count: int) -> Array:
    """Return by how many sigma each of many columns would be estimated in each leftover, `(L, C)`.

    Args:
        regression: whose recordings to look at.
        lefts: what is left of them.
        build: the way that wheels gain (M, W, c) in the columns from one number to another.
        count: C.
    """
    answer = np.zeros((len(lefts), count))
    for first in range(0, count, _CHUNK):
        last = min(first + _CHUNK, count)
        white = []
        for number, windows in enumerate(regression.windows):
            gained = build(number, windows, range(first, last))
            poses = 3 * len(windows.signals.trucks)
            push = np.einsum("mwi,mwc->mic", windows.lever[:, :, :poses], gained)
            still = np.zeros((*windows.measured.shape, last - first))
            white.append(regression.filters[number].whiten(-push, still))
        rows = regression.rows(white)
        answer[:, first:last] = [left.strength(rows) for left in lefts]
    return answer


def windows_in_all(regression: Regression) -> int:
    """Return among how many windows a moment is looked for."""
    return sum(len(windows.ends) for windows in regression.windows)


def travelled(windows: Windows) -> Array:
    """Return the way (M, W) of each wheel in each window [m]."""
    return np.add.reduceat(windows.signals.block.travel, windows.ends[:-1], axis=0)


def wheels_of(regression: Regression) -> tuple[Channel, ...]:
    """Return the wheels of the robot."""
    return regression.windows[0].signals.recording.vehicle.wheels
