"""The growth-rate concept, C 3.3, on one bump: the error of each estimator from interval to interval."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects.crossing import chord_loss
from omnimate.ipec.corrector import correct
from studies.papers.bump_drive import bump_drive
from studies.papers.bump_errors import BumpErrors, bump_errors
from studies.papers.robots import fine

if TYPE_CHECKING:
    from omnimate.vehicle.se2 import Array

LOST = chord_loss(0.075, 0.010)  # [m] C Table I
SPEED, PERIOD, LINK = 0.5, 0.040, 1.0  # [m/s], [s], [m] C 3.1
_BEFORE = 0.5  # [m]


@dataclass(frozen=True, slots=True)
class Growth:
    """Errors, true minus estimated, at each sampling interval from the one in which the bump is met on.

    Attributes:
        plain: Heading [rad] and lateral [m] error of odometry alone, shape `(N, 2)`.
        ipec: Heading [rad] and lateral [m] error of IPEC, C (9)-(16), shape `(N, 2)`.
        seen: Part of the heading's error that the linkage has shown so far [rad], shape `(N,)`.
        printed: Errors by the paper's formulas, C (4)-(8).
    """

    plain: Array
    ipec: Array
    seen: Array
    printed: BumpErrors


def bump_growth(intervals: int = 15) -> Growth:
    """Return what one 10 mm bump under truck a's right wheel does, all else being perfect."""
    robot = fine()
    robot = replace(robot, bus=replace(robot.bus, sync_period=PERIOD))
    drive = bump_drive(robot, LOST, speed=SPEED, before=_BEFORE)
    met = int(np.searchsorted(drive.way, _BEFORE - 1e-9))
    shown = slice(met, met + intervals + 1)
    start = drive.pose_a[0]
    plain = correct(drive.recording, start, method="plain")
    ipec = correct(drive.recording, start, method="clapper")

    def error(path: Array) -> Array:
        return np.asarray((drive.pose_a - path)[shown][:, [2, 1]])

    step = SPEED * PERIOD
    printed = bump_errors(LOST, robot.trucks["a"].wheelbase, step, LINK)
    seen = np.cumsum(ipec.corrections[:, 0])[shown]
    return Growth(error(plain.pose_a), error(ipec.pose_a), seen, printed)
