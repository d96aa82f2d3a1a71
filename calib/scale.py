"""The scaling error E_s: actual over believed mean wheel diameter, U section II-B.

It is measured on straights, with a tape or with fixes. No closed square shows it: wheels that are 1 per
cent too large bring the robot home as surely as a wheelbase that is 1 per cent too small.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from calib.errors import CalibrationError
from calib.recordings import Drive, has_fixes
from vehicle.odometry import arc, integrate
from vehicle.parameters import Truck
from vehicle.se2 import between

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vehicle.parameters import TruckName
    from vehicle.recording import Recording

_SHORTEST = 1.0  # [m] a straight that tells anything
_BENT = math.radians(10.0)  # a straight does not turn farther
_LONGER = 1.01  # than its chord: a drive to and fro is none


@dataclass(frozen=True, slots=True)
class Scale:
    """A measured scaling error.

    Attributes:
        e_s: actual over calculated length.
        sigma: its standard error; nan for a single straight without known accuracy.
        straights: how many.
    """

    e_s: float
    sigma: float
    straights: int

    @property
    def matters(self) -> bool:
        """Whether it differs from 1 by more than three standard errors and by more than 1 in 1000."""
        off = abs(self.e_s - 1.0)
        return off > 1e-3 and not off <= 3.0 * self.sigma


def scale_from_tape(measured: Sequence[float], calculated: Sequence[float]) -> Scale:
    """Return E_s from straights measured with a tape and calculated by odometry [m].

    Raises:
        CalibrationError: there is none, they are not equally many, or a length is not positive.
    """
    if len(measured) != len(calculated) or not measured:
        raise CalibrationError("tape", f"{len(measured)} measured and {len(calculated)} calculated straights")
    if not all(math.isfinite(one) and one > 0.0 for one in (*measured, *calculated)):
        raise CalibrationError("tape", f"lengths {measured}, {calculated}; expected metres above 0")
    ratios = np.divide(measured, calculated)
    if not (ratios.min() > 0.5 and ratios.max() < 2.0):
        raise CalibrationError("tape", f"{measured} m measured, {calculated} m calculated; check the units")
    lengths = np.asarray(calculated, np.float64)
    e_s = float(np.sum(measured) / lengths.sum())
    rest = np.asarray(measured) - e_s * lengths
    sigma = math.nan
    if len(ratios) > 1:
        sigma = math.sqrt(float(rest @ rest) / (len(ratios) - 1) * len(ratios)) / float(lengths.sum())
    return Scale(e_s, sigma, len(ratios))


def scale_from_straights(recordings: Sequence[Recording], truck: TruckName = "a") -> Scale:
    """Return E_s from the straights between two fixes at rest in recordings.

    Raises:
        CalibrationError: there is none; closed squares cannot tell E_s, and it is not made up.
    """
    pairs = [pair for one in recordings if has_fixes(one, truck) for pair in _straights(one, truck)]
    if not pairs:
        source = ", ".join(recording.source for recording in recordings)
        raise CalibrationError(
            source,
            "no straight of a metre or more between two fixes; E_s cannot be read from closed squares: drive "
            "10 m straight, measure the way with a tape, and give --tape MEASURED CALCULATED",
        )
    measured, calculated = zip(*pairs, strict=True)
    return scale_from_tape(measured, calculated)


def _straights(recording: Recording, name: TruckName) -> list[tuple[float, float]]:
    """Return measured and calculated length [m] of each straight from one rest to the next."""
    assert recording.poses is not None  # the caller saw fixes
    truck = recording.vehicle.trucks[name]
    drive = Drive(recording, name, recording.poses.of(name))
    found, times = [], drive.rests()
    for start, end in itertools.pairwise(times):
        travel = drive.wheel_angles(start, end) * drive.radii
        path = integrate(arc(travel[:, 0], travel[:, 1], truck.wheelbase))
        chord = float(np.hypot(*path[-1, :2]))
        way = float(np.abs(travel.mean(axis=1)).sum())
        if chord >= _SHORTEST and way <= _LONGER * chord and np.abs(path[:, 2]).max() <= _BENT:
            step = between(np.nan_to_num(drive.mean_fix(start)), np.nan_to_num(drive.mean_fix(end)))
            found.append((float(np.hypot(*step[:2])), chord))
    return found


def scaled_truck(truck: Truck, e_s: float) -> Truck:
    """Return a truck with both diameters and the wheelbase times E_s.

    Squares tell the wheelbase only in units of the wheels; calibrated by them, it is wrong by E_s as well.
    """
    return Truck(truck.wheelbase * e_s, truck.wheel_diameter_left * e_s, truck.wheel_diameter_right * e_s)
