"""One UMBmark experiment with one truck, from wherever its runs came, and its calibration by each method."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, get_args

from calib.apply import corrected_truck
from calib.chain import solve_exact, solve_weighted, square_returns
from calib.errors import CalibrationError
from calib.optiodom import read_optiodom
from calib.recordings import check_one_robot, square_runs
from calib.return_errors import ReturnErrors
from calib.runs import SquareRun, return_errors
from calib.table import read_table
from calib.umbmark import Correction, Method, solve_printed
from vehicle.se2 import wrap

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from vehicle.parameters import Truck, TruckName
    from vehicle.recording import Recording
    from vehicle.se2 import Array

METHODS: tuple[Method, ...] = get_args(Method)


@dataclass(frozen=True, slots=True)
class Experiment:
    """Return errors, the parameters that they were calculated with, and the runs where they are known.

    Attributes:
        source: where the data came from.
        truck: the parameters of the odometry.
        errors: of the runs.
        runs: empty for a tape-measured table.
    """

    source: str
    truck: Truck
    errors: ReturnErrors
    runs: tuple[SquareRun, ...] = ()

    def evaluate(self, truck: Truck) -> ReturnErrors:
        """Return the errors that the same wheel turns give with other parameters.

        The odometry is calculated anew where the runs are known; otherwise the exact chain of the square
        stands for it.
        """
        side, source = self.errors.side, self.errors.source
        if self.runs:
            return return_errors(self.runs, truck, side, source)
        cw, ccw = square_returns(self.truck, truck, side)
        return ReturnErrors(_less(self.errors.cw, cw), _less(self.errors.ccw, ccw), side, source)


@dataclass(frozen=True, slots=True)
class Calibration:
    """What an experiment makes of a truck by one method.

    Attributes:
        experiment: that it rests on.
        correction: alpha, beta, E_b, E_d.
        truck: the corrected parameters.
        errors: the experiment's return errors evaluated with them.
    """

    experiment: Experiment
    correction: Correction
    truck: Truck
    errors: ReturnErrors

    @property
    def c_left(self) -> float:
        """Factor of the left wheel's diameter, U (4.33); (4.31) where both were equal."""
        return self.truck.wheel_diameter_left / self.experiment.truck.wheel_diameter_left

    @property
    def c_right(self) -> float:
        """Factor of the right wheel's diameter, U (4.33); (4.32) where both were equal."""
        return self.truck.wheel_diameter_right / self.experiment.truck.wheel_diameter_right


def usable_methods(errors: ReturnErrors) -> tuple[Method, ...]:
    """Return the methods whose data are there: headings, and a scatter to weigh by."""
    wanting = set[Method]() if errors.has_headings else {"heading", "weighted"}
    if len(errors.cw) + len(errors.ccw) < 3:
        wanting.add("weighted")
    return tuple(method for method in METHODS if method not in wanting)


def calibrate(experiment: Experiment, method: Method = "exact") -> Calibration:
    """Return the calibration of a truck by one method.

    Raises:
        CalibrationError: the errors are beyond what the method can explain.
    """
    errors, truck = experiment.errors, experiment.truck
    if method == "exact":
        correction = solve_exact(errors, truck)
    elif method == "weighted":
        correction = solve_weighted(errors, truck)
    else:
        correction = solve_printed(errors, truck.wheelbase, method)
    corrected = corrected_truck(truck, correction.e_b, correction.e_d)
    return Calibration(experiment, correction, corrected, experiment.evaluate(corrected))


def experiment_of_recordings(
    recordings: Sequence[Recording], name: TruckName = "a", side: float | None = None
) -> Experiment:
    """Return the experiment that the cw and ccw laps of one robot's recordings make for a truck.

    Args:
        recordings: one or more, of the same robot.
        name: which truck.
        side: of the square [m]; None takes it from run.toml.

    Raises:
        CalibrationError: laps, fixes or a direction are missing, or the recordings are of different robots.
    """
    source = ", ".join(recording.source for recording in recordings)
    check_one_robot(recordings)
    truck = recordings[0].vehicle.trucks.get(name)
    for recording in recordings[1:]:
        if recording.vehicle.trucks.get(name) != truck:
            raise CalibrationError(
                recording.source,
                f"truck {name} differs from that of {recordings[0].source}; expected one robot with one "
                "vehicle.toml: leave out those from before a calibration, or give one for all as --vehicle",
            )
    if truck is None:
        raise CalibrationError(source, f"the robot has no truck {name}")
    runs = tuple(run for recording in recordings for run in square_runs(recording, name))
    return _experiment(source, truck, _side(recordings) if side is None else side, runs)


def experiment_of_table(path: Path | str, truck: Truck, side: float) -> Experiment:
    """Return the experiment of a table of return errors, for the nominal truck and the side [m].

    Raises:
        ReturnTableError: the table cannot be read.
        DirectionError: a direction is missing, or cw and ccw are swapped.
    """
    return Experiment(str(path), truck, read_table(path, side))


def experiment_of_optiodom(folder: Path | str, side: float | None = None) -> Experiment:
    """Return the experiment of an OptiOdom folder; `side` [m] stands in for that of its metadata.

    Raises:
        OptiOdomError: it is no set of squares of the differential robot.
        DirectionError: a direction is missing, or a run is not one square.
    """
    data = read_optiodom(folder)
    return _experiment(str(folder), data.truck, data.side if side is None else side, data.runs)


def _experiment(source: str, truck: Truck, side: float, runs: tuple[SquareRun, ...]) -> Experiment:
    """Return the experiment of runs, each checked to be a square of `side` [m]."""
    for run in runs:
        run.check(truck, side)
    return Experiment(source, truck, return_errors(runs, truck, side, source), runs)


def _side(recordings: Sequence[Recording]) -> float:
    """Return the one side that all recordings state [m]."""
    stated = {recording.run.side for recording in recordings if recording.run is not None}
    sides = [side for side in stated if side is not None]
    if len(sides) != 1:
        raise CalibrationError(recordings[0].source, "run.toml states no side, or not the same one; give it")
    return sides[0]


def _less(runs: Array, expected: Array) -> Array:
    """Return the errors `(n, 3)` less what the chain explains `(3,)`."""
    rest = runs - expected
    rest[:, 2] = wrap(rest[:, 2])
    return rest
