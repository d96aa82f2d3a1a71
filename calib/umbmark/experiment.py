"""One UMBmark experiment with one truck, from any source of runs, and its calibration by each method.

A table of tape-measured return errors is a CSV file, whose header states the units; each line is one run. The
heading may be left out:

    direction,x_mm,y_mm,theta_deg
    cw,-152,-148,-1.9
    ccw,305,-298,2.7

x points forward at the start, y to the left; each value is absolute minus calculated, U (3.1). Lengths in
`_mm`, `_cm` or `_m`, headings in `_deg` or `_rad`. Empty lines and lines that begin with # are skipped.
"""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, get_args

import numpy as np

from omnimate.calib.apply import corrected_truck, factors_between
from omnimate.calib.errors import CalibrationError, ReturnTableError
from omnimate.calib.recordings import check_one_robot, check_one_truck
from omnimate.calib.umbmark.exact import solve_exact, square_returns
from omnimate.calib.umbmark.printed import Correction, Method, solve_printed
from omnimate.calib.umbmark.return_errors import MAX_RETURN_SIDES, ReturnErrors, check_directions
from omnimate.calib.umbmark.runs import SquareRun, return_errors, square_runs
from omnimate.vehicle.errors import describe_read_error
from omnimate.vehicle.se2 import wrap

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.calib.apply import Factors
    from omnimate.calib.umbmark.runs import SquareDirection
    from omnimate.vehicle.parameters import Truck, TruckName
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array

METHODS: tuple[Method, ...] = get_args(Method)
_UNITS = {
    "x": {"mm": 1e-3, "cm": 1e-2, "m": 1.0},
    "y": {"mm": 1e-3, "cm": 1e-2, "m": 1.0},
    "theta": {"deg": math.pi / 180.0, "rad": 1.0},
}
_HEADER = "direction,x_mm,y_mm,theta_deg"


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

        The odometry is calculated again where the runs are known; otherwise the exact chain of the square
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


@dataclass(frozen=True, slots=True)
class _TableColumn:
    name: str  # as in the header
    quantity: str  # direction, x, y or theta
    scale: float  # to SI units


def read_table(path: Path | str, side: float) -> ReturnErrors:
    """Return the return errors of a CSV table for a square of `side` [m].

    Raises:
        ReturnTableError: The table cannot be read; the error names line and column.
        DirectionError: A direction is missing, or cw and ccw are swapped.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise ReturnTableError(path, 1, None, f"cannot be read: {describe_read_error(error)}") from error
    rows = [
        (number, [cell.strip() for cell in next(csv.reader([line]))])
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not rows:
        raise ReturnTableError(path, 1, None, f"empty; expected a header such as {_HEADER}")
    columns = _table_columns(path, *rows[0])
    runs: dict[str, list[list[float]]] = {"cw": [], "ccw": []}
    for line, cells in rows[1:]:
        direction, values = _table_run(path, line, cells, columns, side)
        runs[direction].append(values)
    clusters = {name: np.array(lines, np.float64).reshape(-1, 3) for name, lines in runs.items()}
    errors = ReturnErrors(clusters["cw"], clusters["ccw"], side, str(path))
    check_directions(errors)
    return errors


def _table_columns(path: Path, line: int, cells: list[str]) -> list[_TableColumn]:
    columns = []
    for number, name in enumerate(cells, start=1):
        quantity, _, unit = name.partition("_")
        if name == "direction":
            columns.append(_TableColumn(name, name, 1.0))
        elif unit in _UNITS.get(quantity, {}):
            columns.append(_TableColumn(name, quantity, _UNITS[quantity][unit]))
        else:
            expected = "direction, x_mm, y_mm, theta_deg (or x_cm, x_m, theta_rad and so on)"
            raise ReturnTableError(path, line, number, f"column {name!r} is unknown; expected {expected}")
    quantities = [column.quantity for column in columns]
    for quantity in ("direction", "x", "y"):
        if quantity not in quantities:
            raise ReturnTableError(path, line, None, f"no column {quantity}; expected {_HEADER}")
    for quantity in set(quantities):
        if quantities.count(quantity) > 1:
            raise ReturnTableError(path, line, None, f"column {quantity} stands twice; expected {_HEADER}")
    return columns


def _table_run(
    path: Path, line: int, cells: list[str], columns: list[_TableColumn], side: float
) -> tuple[str, list[float]]:
    """Return the direction and the return error (x, y, theta) [m, m, rad] of one line."""
    if len(cells) != len(columns):
        raise ReturnTableError(
            path, line, None, f"{len(cells)} values; expected {len(columns)} as in the header"
        )
    direction = ""
    error = {"x": math.nan, "y": math.nan, "theta": math.nan}
    for number, (cell, column) in enumerate(zip(cells, columns, strict=True), start=1):
        if column.quantity != "direction":
            error[column.quantity] = _cell_value(path, line, number, cell, column, side)
        elif cell.lower() in {"cw", "ccw"}:
            direction = cell.lower()
        else:
            raise ReturnTableError(path, line, number, f"direction {cell!r}; expected cw or ccw")
    return direction, [error["x"], error["y"], error["theta"]]


def _cell_value(path: Path, line: int, number: int, cell: str, column: _TableColumn, side: float) -> float:
    if column.quantity == "theta" and not cell:
        return math.nan
    try:
        value = float(cell) * column.scale
    except ValueError:
        raise ReturnTableError(path, line, number, f"{column.name} {cell!r}; expected a number") from None
    limit, words = (
        (math.pi, "half a turn")
        if column.quantity == "theta"
        else (MAX_RETURN_SIDES * side, "the whole way around the square")
    )
    if not abs(value) < limit:
        raise ReturnTableError(
            path,
            line,
            number,
            f"{column.name} {cell} is no return error; expected less than {words}; check the unit",
        )
    return value
