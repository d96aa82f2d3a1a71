"""The return errors of a set of square runs, which UMBmark measures, and their summary, U (3.1)-(3.4)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.errors import CalibrationError, DirectionError

if TYPE_CHECKING:
    from omnimate.vehicle.se2 import Array

# Directions count as swapped if the clusters lie off their diagonals by this factor of the distance along
# them, and by this many standard errors of the mean (assumptions).
_SWAPPED_RATIO = 3.0
_SWAPPED_SEM = 4.0
MAX_RETURN_SIDES = 4.0  # [sides] largest return error: the length of the path
_SQRT_HALF = math.sqrt(0.5)
MIRROR = np.array([1.0, -1.0, -1.0])  # signs of x, y, theta of a cw run seen as a ccw run


@dataclass(frozen=True, slots=True)
class ReturnErrors:
    """Absolute minus calculated pose at the end of each run, U (3.1), in the frame of the run's start.

    Raises:
        CalibrationError: The side is not a length, or a position is not a number.
        DirectionError: A direction has no run.
    """

    cw: Array  # x [m], y [m], theta [rad] of each run, `(n, 3)`; theta is nan where it was not measured
    ccw: Array  # likewise, `(m, 3)`
    side: float  # length of each side of the square [m]
    source: str = "return errors"  # file or folder that the errors come from, for messages

    def __post_init__(self) -> None:
        if not (math.isfinite(self.side) and self.side > 0.0):
            raise CalibrationError(
                self.source, f"side {self.side} of the square; expected a length in metres"
            )
        for direction, runs in (("cw", self.cw), ("ccw", self.ccw)):
            if len(runs) == 0:
                raise DirectionError(
                    self.source,
                    f"no {direction} run; one direction alone cannot separate wheelbase from diameters: "
                    "drive the square in both",
                )
            if not np.isfinite(runs[:, :2]).all():
                raise CalibrationError(self.source, f"a {direction} run has a position that is not a number")
            runs.flags.writeable = False

    @property
    def centres(self) -> Array:
        """Centres of gravity `(2, 3)`, cw then ccw, U (3.2)."""
        return np.stack([self.cw.mean(axis=0), self.ccw.mean(axis=0)])

    @property
    def has_headings(self) -> bool:
        """Whether the heading of every run was measured."""
        return bool(np.isfinite(self.cw[:, 2]).all() and np.isfinite(self.ccw[:, 2]).all())

    @property
    def radii(self) -> Array:
        """Distances `(2,)` of the two centres of gravity from the origin [m], U (3.3)."""
        return np.asarray(np.hypot(self.centres[:, 0], self.centres[:, 1]), np.float64)

    @property
    def e_max_syst(self) -> float:
        """The measure of odometric accuracy for systematic errors [m], U (3.4)."""
        return float(self.radii.max())

    @property
    def worst(self) -> float:
        """The largest distance of any single run from the origin [m]."""
        return float(max(np.hypot(runs[:, 0], runs[:, 1]).max() for runs in (self.cw, self.ccw)))

    @property
    def runs(self) -> tuple[int, int]:
        """Number of cw and of ccw runs."""
        return len(self.cw), len(self.ccw)

    @property
    def freedom(self) -> int:
        """Degrees of freedom of the scatter: the number of runs minus two centres."""
        return sum(self.runs) - 2

    @property
    def deviations(self) -> Array:
        """Deviations `(N, 3)` of all runs from the centre of their direction, those of cw mirrored.

        The square driven cw is the mirror image of the square driven ccw, and so is its scatter. Mirroring
        (y and theta change sign) preserves correlations.
        """
        return np.concatenate([(self.cw - self.centres[0]) * MIRROR, self.ccw - self.centres[1]])

    @property
    def covariance(self) -> Array:
        """Covariance `(3, 3)` of one ccw run; nan without a degree of freedom or without headings."""
        if self.freedom == 0:
            return np.full((3, 3), np.nan)
        return np.asarray(self.deviations.T @ self.deviations / self.freedom, np.float64)

    @property
    def covariance_of_centres(self) -> Array:
        """Covariance `(6, 6)` of the two centres of gravity, cw then ccw."""
        both, covariance = np.zeros((6, 6)), self.covariance
        both[:3, :3] = np.outer(MIRROR, MIRROR) * covariance / self.runs[0]
        both[3:, 3:] = covariance / self.runs[1]
        return both

    @property
    def sigma(self) -> Array:
        """Standard deviations `(3,)` of one run's x, y (pooled, as in U section V) [m] and theta [rad]."""
        variance = np.diag(self.covariance).copy()
        variance[:2] = variance[:2].mean()
        return np.sqrt(variance)

    @property
    def scatter(self) -> float:
        """Standard deviation of one return position per axis [m], over both clusters; nan for 1 + 1 runs."""
        return float(self.sigma[0])

    @property
    def sem(self) -> float:
        """Standard error of the mean per axis [m] of the smaller cluster, U section V."""
        return self.scatter / math.sqrt(min(self.runs))

    @property
    def second_pass_helps(self) -> bool | None:
        """Whether E_max,syst exceeds 3 SEM, U section V; None where the scatter is unknown."""
        return None if math.isnan(self.sem) else self.e_max_syst > 3.0 * self.sem


def check_directions(errors: ReturnErrors) -> None:
    """Raise an error if the clusters lie on each other's diagonals.

    By U (4.17), (4.18) and their y counterparts the cw cluster lies on y = x and the ccw cluster on y = -x;
    with the labels swapped, or y taken to the right, it is the other way round.

    Raises:
        DirectionError: Both clusters lie there by more than the scatter of the runs explains.
    """
    (cw_x, cw_y, _), (ccw_x, ccw_y, _) = errors.centres
    along = _SQRT_HALF * math.hypot(cw_x + cw_y, ccw_x - ccw_y)
    off = _SQRT_HALF * math.hypot(cw_x - cw_y, ccw_x + ccw_y)
    sem = 0.0 if math.isnan(errors.sem) else errors.sem
    if off > _SWAPPED_RATIO * along and off > _SWAPPED_SEM * sem:
        raise DirectionError(
            errors.source,
            f"the cw runs return to ({1e3 * cw_x:.0f}, {1e3 * cw_y:.0f}) mm and the ccw runs to "
            f"({1e3 * ccw_x:.0f}, {1e3 * ccw_y:.0f}) mm; expected x = y for cw and x = -y for ccw: "
            "cw and ccw are swapped, or y was measured to the right instead of the left",
        )


def stop_rule(errors: ReturnErrors) -> str:
    """Return whether another pass helps, by U section V: E_max,syst against 3 SEM."""
    size = f"E_max,syst {_millimetres(errors.e_max_syst)}"
    helps = errors.second_pass_helps
    if helps is None:
        return f"{size}; SEM unknown with one run in each direction: drive five"
    limit = f"3 SEM = {_millimetres(3.0 * errors.sem)}"
    if helps:
        return f"{size} > {limit}: the systematic errors stand out, this pass will help"
    return f"{size} <= {limit}: the runs' scatter explains it, another pass is unlikely to help"


def _millimetres(length: float) -> str:
    return f"{1e3 * length:.1f} mm"
