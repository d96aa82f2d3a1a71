"""One UMBmark experiment with one truck, from any source of runs, and its calibration by each method."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, get_args

import numpy as np

from omnimate.calib.apply import corrected_truck, factors_between
from omnimate.calib.errors import CalibrationError
from omnimate.calib.recordings import check_one_robot, check_one_truck
from omnimate.calib.umbmark.exact import solve_exact, square_returns
from omnimate.calib.umbmark.printed import Correction, Method, solve_printed
from omnimate.calib.umbmark.return_errors import ReturnErrors
from omnimate.calib.umbmark.runs import SquareRun, return_errors, square_runs
from omnimate.calib.umbmark.table import read_table
from omnimate.vehicle.se2 import wrap

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from omnimate.calib.apply import Factors
    from omnimate.calib.umbmark.runs import SquareDirection
    from omnimate.vehicle.parameters import Truck, TruckName
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array

METHODS: tuple[Method, ...] = get_args(Method)


@dataclass(frozen=True, slots=True)
class Experiment:
    """Return errors, the parameters that they were calculated with, and the runs where they are known."""

    source: str  # file or folder that the data come from
    truck: Truck  # parameters that the odometry used
    errors: ReturnErrors
    runs: tuple[SquareRun, ...] = ()  # the runs; empty for a tape-measured table

    def without(self, direction: SquareDirection, place: int) -> Experiment:
        """Return the experiment without the run at a place, from 0, among those of its direction."""
        same = [run for run in self.runs if run.direction == direction]
        runs = tuple(run for run in self.runs if not same or run is not same[place])
        cw, ccw = self.errors.cw, self.errors.ccw
        if direction == "cw":
            cw = np.delete(cw, place, axis=0)
        else:
            ccw = np.delete(ccw, place, axis=0)
        return replace(self, errors=replace(self.errors, cw=cw, ccw=ccw), runs=runs)

    def evaluate(self, truck: Truck) -> ReturnErrors:
        """Return the errors that the same wheel turns give with other parameters.

        The odometry is calculated anew where the runs are known; otherwise the exact chain of the square
        stands for it.
        """
        side, source = self.errors.side, self.errors.source
        if self.runs:
            return return_errors(self.runs, truck, side, source)
        cw, ccw = square_returns(self.truck, truck, side)
        return ReturnErrors(_subtract(self.errors.cw, cw), _subtract(self.errors.ccw, ccw), side, source)


@dataclass(frozen=True, slots=True)
class Calibration:
    """The calibration of a truck from one experiment by one method."""

    experiment: Experiment  # the experiment that the calibration rests on
    correction: Correction  # the correction alpha, beta, E_b, E_d
    truck: Truck  # the corrected parameters
    errors: ReturnErrors  # return errors of the experiment with the corrected parameters

    @property
    def factors(self) -> Factors:
        """Factors from the nominal parameters to the corrected ones."""
        return factors_between(self.experiment.truck, self.truck)


def usable_methods(errors: ReturnErrors) -> tuple[Method, ...]:
    """Return the methods that the data allow; some need headings, one needs a scatter for its weights."""
    wanting = set[Method]() if errors.has_headings else {"heading", "weighted"}
    if errors.freedom == 0:
        wanting.add("weighted")
    return tuple(method for method in METHODS if method not in wanting)


def calibrate(experiment: Experiment, method: Method = "exact") -> Calibration:
    """Return the calibration of a truck by one method.

    Raises:
        CalibrationError: The method cannot explain the errors.
    """
    errors, truck = experiment.errors, experiment.truck
    if method == "exact" or method == "weighted":  # noqa: PLR1714  # the type checker narrows this form only
        correction = solve_exact(errors, truck, method)
    else:
        correction = solve_printed(errors, truck.wheelbase, method)
    corrected = corrected_truck(truck, correction.e_b, correction.e_d)
    return Calibration(experiment, correction, corrected, experiment.evaluate(corrected))


def experiment_of_recordings(
    recordings: Sequence[Recording], name: TruckName = "a", side: float | None = None
) -> Experiment:
    """Return the experiment of one truck from the cw and ccw laps of one robot's recordings.

    Args:
        recordings: One or more recordings of the same robot.
        name: Name of the truck, a or b.
        side: Length of each side of the square [m]; None takes it from run.toml.

    Raises:
        CalibrationError: Laps, fixes or a direction are missing, or the recordings are of different robots.
    """
    check_one_robot(recordings)
    check_one_truck(recordings, name)
    source = ", ".join(recording.source for recording in recordings)
    truck = recordings[0].vehicle.trucks[name]
    runs = tuple(run for recording in recordings for run in square_runs(recording, name))
    return experiment_of_runs(source, truck, _side(recordings) if side is None else side, runs)


def experiment_of_table(path: Path | str, truck: Truck, side: float) -> Experiment:
    """Return the experiment of a table of return errors, for the nominal truck and the side [m].

    Raises:
        ReturnTableError: The table cannot be read.
        DirectionError: A direction is missing, or cw and ccw are swapped.
    """
    return Experiment(str(path), truck, read_table(path, side))


def experiment_of_runs(source: str, truck: Truck, side: float, runs: tuple[SquareRun, ...]) -> Experiment:
    """Return the experiment of runs, each checked to be a square of `side` [m].

    Raises:
        DirectionError: A direction is missing, or a run is not one square.
    """
    for run in runs:
        run.check(truck, side)
    return Experiment(source, truck, return_errors(runs, truck, side, source), runs)


def _side(recordings: Sequence[Recording]) -> float:
    """Return the side [m] that all recordings state."""
    stated = {recording.run.side for recording in recordings if recording.run is not None}
    sides = [side for side in stated if side is not None]
    if len(sides) != 1:
        raise CalibrationError(recordings[0].source, "run.toml states no side, or not the same one; give it")
    return sides[0]


def _subtract(runs: Array, expected: Array) -> Array:
    """Return the errors `(n, 3)` minus the expected error `(3,)`."""
    rest = runs - expected
    rest[:, 2] = wrap(rest[:, 2])
    return rest
