"""A CSV file and a mapping that says which column is what: one recording.

The mapping is a TOML file; docs/import.md describes it.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from imports.clock import recording_of
from imports.csv_reading import DELIMITERS, read_csv_table
from imports.errors import MappingError, SourceError
from imports.poses import joined, poses_of
from imports.robots import robot_of
from imports.series import Series, check_times
from imports.tables import Table, read_table
from imports.units import METRES, RADIANS, SECONDS, UNITS
from vehicle.recording import Lap, Run

if TYPE_CHECKING:
    from collections.abc import Iterator

    from imports.csv_table import CsvTable
    from vehicle.parameters import Channel, VehicleParameters
    from vehicle.recording import Poses, Recording
    from vehicle.se2 import Array

TIME_UNITS = (*SECONDS, "iso")


def read_csv(path: Path | str, mapping: Path | str, vehicle: VehicleParameters | None = None) -> Recording:
    """Return the recording that a CSV file holds.

    Args:
        path: of the CSV file.
        mapping: TOML file that says which column is what.
        vehicle: the robot; that of the mapping where it is None.

    Raises:
        MappingError: the mapping is wrong; it names file and key.
        SourceError: the CSV file is; it names file, line and column.
        VehicleFileError: the robot's file is.
    """
    table, path = read_table(mapping), Path(path)
    robot = robot_of(table, Path(mapping).parent, vehicle)
    style = table.table("csv")
    cells = _cells(path, style)
    clock = table.table("time")
    time = _time(cells, clock)
    series = dict(_channels(table, cells, time, robot))
    poses = joined(_poses(table, cells, style, time, robot))
    run = Run(_protocol(table), None, (Lap("none", float(time[0]), float(time[-1])),))
    for one in (clock, style, table):
        one.done()
    return recording_of(robot, series, str(path), poses, run)


def _protocol(table: Table) -> str:
    run = table.table("run")
    protocol = run.text("protocol", "free")
    run.done()
    return protocol


def _cells(path: Path, style: Table) -> CsvTable:
    """Return the cells of a file in the style that `[csv]` states."""
    delimiter = style.text("delimiter", "", among=("", *DELIMITERS))
    return read_csv_table(path, delimiter, int(style.number("skip", 0)))


def _time(cells: CsvTable, table: Table) -> Array:
    """Return the times `(N,)` of the rows [s]."""
    column, unit = table.column("column"), table.text("unit", "s", among=TIME_UNITS)
    raw = cells.moments(column) if unit == "iso" else cells.numbers(column) * SECONDS[unit]
    time = raw + table.number("offset", 0.0)
    check_times(time, lambda row: cells.place(row, column))
    return np.asarray(time, np.float64)


def _channels(
    table: Table, cells: CsvTable, time: Array, robot: VehicleParameters
) -> Iterator[tuple[Channel, Series]]:
    given = dict(table.tables("channel", robot.channels))
    for channel in robot.channels:
        if channel not in given:
            raise MappingError(table.source, f'channel {channel} is missing; expected [channel."{channel}"]')
        one = given[channel]
        column, unit = one.column("column"), one.text("unit", "counts", among=UNITS)
        value = cells.numbers(column)
        if one.switch("increments"):
            value = _summed(value, cells, column)
        one.done()
        yield channel, Series(time, value, unit, f"{cells.path}: column {column}")


def _summed(value: Array, cells: CsvTable, column: str | int) -> Array:
    missing = np.flatnonzero(np.isnan(value))
    if len(missing):
        raise SourceError(
            cells.place(int(missing[0]), column), "empty; increments are summed, so none may be missing"
        )
    return np.cumsum(value)


def _poses(
    table: Table, cells: CsvTable, style: Table, time: Array, robot: VehicleParameters
) -> Iterator[Poses]:
    names = tuple(robot.trucks)
    for name, one in table.tables("poses", names):
        truck = next(truck for truck in names if truck == name)
        other = one.text("file", "")
        held = _cells(cells.path.parent / other, style) if other else cells
        clock = one.table("time")
        when = _time(held, clock) if other or clock.names() else time
        clock.done()
        length, angle = one.text("length", "m", among=METRES), one.text("angle", "rad", among=RADIANS)
        factors = (METRES[length], METRES[length], RADIANS[angle])
        pose, sigma = (
            np.column_stack([_optional(held, one, f"{prefix}{key}") for key in ("x", "y", "theta")]) * factors
            for prefix in ("", "sigma_")
        )
        one.done()
        if not np.isfinite(pose).any():
            raise MappingError(one.source, "no pose in it; expected columns x and y, or theta")
        yield poses_of(truck, when, pose, sigma)


def _optional(cells: CsvTable, table: Table, key: str) -> Array:
    """Return a column `(N,)`; nan where the mapping names none."""
    if key not in table:
        table.number(key, 0.0)  # it may be there
        return np.full(len(cells.rows), np.nan)
    return cells.numbers(table.column(key))
