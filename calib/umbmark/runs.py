"""Square runs: measured end pose, and rotation of the wheels."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from omnimate.calib.errors import CalibrationError, DirectionError, FrozenChannelError
from omnimate.calib.fixes import WheelsAndFixes
from omnimate.calib.recordings import has_fixes
from omnimate.calib.umbmark.return_errors import ReturnErrors
from omnimate.vehicle.arcs import arc, integrate
from omnimate.vehicle.se2 import Array, between, wrap

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.vehicle.parameters import Truck, TruckName
    from omnimate.vehicle.recording import Recording

SquareDirection = Literal["cw", "ccw"]

_TURN_TOLERANCE = math.radians(45.0)  # [rad] tolerance of the total rotation: half a corner
_FROZEN_WHEEL_TRAVEL = 0.05  # [m] of the other wheel: one without counts is then frozen (assumption)
_LENGTH_TOLERANCE = 0.15  # [1] relative tolerance of the total length (assumption)


@dataclass(frozen=True, slots=True)
class SquareRun:
    """One run between two absolute fixes."""

    direction: SquareDirection  # direction in which the square was driven
    absolute: Array  # second fix seen from the first: x [m], y [m], theta [rad] (nan if unknown), `(3,)`
    wheel_angles: Array  # angle by which the left and the right wheel turned in each step [rad], `(N, 2)`
    source: str  # name of the run, for messages

    def path(self, truck: Truck) -> Array:
        """Return the poses `(N+1, 3)` by dead reckoning with a truck's parameters, from (0, 0, 0)."""
        left, right = (self.wheel_angles * truck.radii).T
        return integrate(arc(left, right, truck.wheelbase))

    def return_error(self, truck: Truck) -> Array:
        """Return absolute minus calculated pose `(3,)`, U (3.1)."""
        error = self.absolute - self.path(truck)[-1]
        return np.array([error[0], error[1], wrap(error[2])])

    def check(self, truck: Truck, side: float) -> None:
        """Raise an error if the wheels did not drive one square of `side` [m] in the stated direction.

        Raises:
            FrozenChannelError: A wheel does not count while the other one turns.
            DirectionError: The total rotation of the odometry is not -360 degrees (cw) or +360 degrees (ccw).
            CalibrationError: The path is not four sides long.
        """
        self._check_frozen(truck)
        self._check_rotation(truck)
        length = float(np.abs((self.wheel_angles * truck.radii).mean(axis=1)).sum())
        if abs(length - 4.0 * side) > _LENGTH_TOLERANCE * 4.0 * side:
            raise CalibrationError(
                self.source,
                f"by its wheels this run is {length:.2f} m long; expected 4 x {side:g} m; "
                "check the side (one leg, not the whole path) and the diameters",
            )

    def _check_frozen(self, truck: Truck) -> None:
        travel = np.abs(self.wheel_angles * truck.radii)
        for wheel, other, name in ((0, 1, "left"), (1, 0, "right")):
            stands = travel[:, wheel] == 0.0
            alone = float(np.bincount(np.cumsum(~stands), weights=travel[:, other] * stands).max())
            if alone > _FROZEN_WHEEL_TRAVEL:
                raise FrozenChannelError(
                    self.source,
                    f"{name} wheel:",
                    f"it did not count while the other one rolled {alone:.2f} m; in a square both turn: "
                    "check its encoder, its cable and its cob_id",
                )

    def _check_rotation(self, truck: Truck) -> None:
        expected = -2.0 * math.pi if self.direction == "cw" else 2.0 * math.pi
        turned = float(self.path(truck)[-1, 2])
        if abs(turned - expected) <= _TURN_TOLERANCE:
            return
        if abs(turned + expected) <= _TURN_TOLERANCE:
            advice = "the other way round: cw and ccw, or the left and the right wheel, are swapped"
        elif abs(turned - 0.75 * expected) <= _TURN_TOLERANCE:
            advice = "the last turn is missing: UMBmark needs all four, and the fix after them"
        else:
            advice = "not one square: check the lap's start and end and its fixes"
        raise DirectionError(
            self.source,
            f"by its wheels this {self.direction} run turned {math.degrees(turned):+.0f} degrees; "
            f"expected {math.degrees(expected):+.0f}; {advice}",
        )


def return_errors(runs: Sequence[SquareRun], truck: Truck, side: float, source: str) -> ReturnErrors:
    """Return the return errors of runs, dead-reckoned with a truck's parameters; `side` in metres.

    Raises:
        DirectionError: a direction is missing.
    """
    by_direction = {
        direction: np.array(
            [run.return_error(truck) for run in runs if run.direction == direction], np.float64
        ).reshape(-1, 3)
        for direction in ("cw", "ccw")
    }
    return ReturnErrors(by_direction["cw"], by_direction["ccw"], side, source)


def square_runs(recording: Recording, truck: TruckName = "a") -> tuple[SquareRun, ...]:
    """Return a run for each cw or ccw lap of a recording.

    The fix before is the last one at rest before the lap, the fix after the first one at rest after it; all
    fixes of the same rest are averaged with their inverse variances. The wheels count between exactly these.

    Raises:
        CalibrationError: The recording has no laps, or no absolute poses of this truck.
        FixError: A lap has no fix before or after it.
    """
    if recording.run is None:
        raise CalibrationError(recording.source, "no run.toml; UMBmark needs the laps and their directions")
    if recording.poses is None or not has_fixes(recording, truck):
        raise CalibrationError(
            recording.source, f"poses.csv has no pose of truck {truck}; UMBmark needs fixes"
        )
    drive = WheelsAndFixes(recording, truck, recording.poses.of(truck))
    runs = []
    for number, lap in enumerate(recording.run.laps, start=1):
        if lap.direction == "none":
            continue
        source = f"{recording.source}, lap {number}, truck {truck}"
        start, first = drive.fix_before(lap.start, source)
        end, last = drive.fix_after(lap.end, source)
        angles = drive.steps(start, end) / recording.vehicle.trucks[truck].radii
        runs.append(SquareRun(lap.direction, between(first, last), angles, source))
    return tuple(runs)
