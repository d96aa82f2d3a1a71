"""Whether a wheel's number that is said to be wrong was the same during the whole recording."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import chdtrc

from omnimate.effects.block import wheel_number
from omnimate.effects.effect import WheelEffect
from omnimate.mismatch.candidates.nuisances import MODES, drift_waves

if TYPE_CHECKING:
    from omnimate.mismatch.fit import Fitted
    from omnimate.vehicle.se2 import Array

POINTS = 25  # of a recording at which a change is looked at: eight for each of its waves
LEAST = 0.5  # share of a wrong number that is there all the time, where a constant is wrong: assumption
UNUSUAL = 0.05  # declared: one change in twenty that robots in use show is called unusual


@dataclass(frozen=True, slots=True)
class RollingError:
    """How much more per turn a wheel rolls than it should, where that is not constant."""

    begin: float  # at the beginning of a recording, as a share
    end: float  # the same at its end


def changing_error(fit: Fitted, number: int) -> RollingError | None:
    """Return the error of a wheel's number, effect `number` of a fit, if it changes; None if it does not.

    A number that is wrong is wrong all the time. If the wheel had its nominal size for a part of the drive,
    and changed more than tyres do that warm up, no constant says what is wrong.
    """
    term, effect = fit.chosen.terms[number], fit.chosen.effects[number]
    if not (term.kind.calibrated and isinstance(effect, WheelEffect)):
        return None
    wheel = wheel_number(effect.component)
    block = fit.regression.windows[0].signals.block
    travel = block.travel[:, wheel]
    gained = float(travel @ effect.travelled(block, wheel) / (travel @ travel)) - 1.0
    sizes = _drift(fit, wheel)
    curve = gained + drift_waves(POINTS) @ sizes
    is_unusual = float(chdtrc(MODES, sizes @ sizes)) < UNUSUAL
    if is_unusual and float(np.min(curve / gained)) < LEAST:
        return RollingError(float(curve[0]), float(curve[-1]))
    return None


def _drift(fit: Fitted, wheel: int) -> Array:
    """Return the posterior mean (MODES,) of a wheel's slow change, in standard deviations of a usual one."""
    products = fit.nuisance.T @ fit.nuisance
    scores = fit.nuisance.T @ fit.regression.white[:, 0]
    sizes = np.linalg.solve(products + np.eye(len(products)), scores)
    return np.asarray(sizes[wheel * MODES : (wheel + 1) * MODES])
