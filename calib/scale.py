"""The scaling error E_s: actual over nominal mean wheel diameter, U section II-B.

It is measured on straights, with a tape or with fixes. It is not observable on closed squares: wheels 1 per
cent too large have the same effect there as a wheelbase 1 per cent too small.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.errors import CalibrationError
from omnimate.calib.fixes import WheelsAndFixes
from omnimate.calib.recordings import has_fixes
from omnimate.vehicle.arcs import arc, integrate
from omnimate.vehicle.parameters import Truck
from omnimate.vehicle.se2 import between

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.vehicle.parameters import TruckName
    from omnimate.vehicle.recording import Recording

_MIN_STRAIGHT = 1.0  # [m] shortest straight that is used: 2 mm of a fix are 0.2 % of it
_MAX_TURN = math.radians(10.0)  # [rad] largest change of heading along a straight (assumption)
_MAX_DETOUR = 1.01  # [1] largest travel over chord, so that driving out and back is excluded


@dataclass(frozen=True, slots=True)
class Scale:
    """A measured scaling error."""

    e_s: float  # actual over calculated length
    sigma: float  # standard error of `e_s`; nan for a single straight
    straights: int  # number of straights that were measured

    @property
    def is_significant(self) -> bool:
        """Whether it differs from 1 by more than three standard errors and by more than 1 in 1000."""
        off = abs(self.e_s - 1.0)
        return off > 1e-3 and not off <= 3.0 * self.sigma


def scale_from_tape(measured: Sequence[float], calculated: Sequence[float]) -> Scale:
    """Return E_s from straights measured with a tape and calculated by odometry [m].

    Raises:
        CalibrationError: There is no straight, the lists differ in length, or a length is not positive.
    """
    if len(measured) != len(calculated) or not measured:
        raise CalibrationError("tape", f"{len(measured)} measured and {len(calculated)} calculated straights")
    if not all(math.isfinite(length) and length > 0.0 for length in (*measured, *calculated)):
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
        CalibrationError: There is no straight; E_s cannot be measured on closed squares.
    """
    pairs = [
        pair
        for recording in recordings
        if has_fixes(recording, truck)
        for pair in _straights(recording, truck)
    ]
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
    assert recording.poses is not None  # the caller checked that there are fixes
    truck = recording.vehicle.trucks[name]
    drive = WheelsAndFixes(recording, name, recording.poses.of(name))
    straights, times = [], drive.rests()
    for start, end in itertools.pairwise(times):
        travel = drive.steps(start, end)
        path = integrate(arc(travel[:, 0], travel[:, 1], truck.wheelbase))
        chord = float(np.hypot(*path[-1, :2]))
        length = float(np.abs(travel.mean(axis=1)).sum())
        straight = length <= _MAX_DETOUR * chord and np.abs(path[:, 2]).max() <= _MAX_TURN
        if chord >= _MIN_STRAIGHT and straight:
            step = between(np.nan_to_num(drive.mean_fix(start)), np.nan_to_num(drive.mean_fix(end)))
            straights.append((float(np.hypot(*step[:2])), chord))
    return straights


def scaled_truck(truck: Truck, e_s: float) -> Truck:
    """Return a truck with both diameters and the wheelbase times E_s.

    Squares identify the wheelbase only relative to the wheels, so it is wrong by E_s as well.
    """
    return Truck(truck.wheelbase * e_s, truck.wheel_diameter_left * e_s, truck.wheel_diameter_right * e_s)
