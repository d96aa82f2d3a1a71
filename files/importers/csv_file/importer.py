"""A recording from a CSV file and a mapping that says which column holds which quantity.

The mapping is a TOML file; docs/how-to/csv-file.md describes it.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from omnimate.files.errors import MappingError, SourceError
from omnimate.files.importers.clock import recording_of
from omnimate.files.importers.csv_file.table import DELIMITERS, read_csv_table
from omnimate.files.importers.robots import robot_of
from omnimate.files.importers.series import Series, check_times, merge_poses, poses_of
from omnimate.files.importers.tables import Table, read_table
from omnimate.files.importers.units import METRES, RADIANS, SECONDS, UNITS
from omnimate.files.recordings.poses_csv import EXPECTED_SIGMA
from omnimate.vehicle.recording import Lap, Run

if TYPE_CHECKING:
    from collections.abc import Iterator

    from omnimate.files.importers.csv_file.table import CsvTable
    from omnimate.vehicle.parameters import Channel, VehicleParameters
    from omnimate.vehicle.recording import Poses, Recording
    from omnimate.vehicle.se2 import Array

TIME_UNITS = (*SECONDS, "iso")


def read_csv(path: Path | str, mapping: Path | str, vehicle: VehicleParameters | None = None) -> Recording:
    """Return the recording that a CSV file holds.

    The mapping is a TOML file; the robot is that of the mapping where none is given.

    Raises:
        MappingError: The mapping is wrong; the message names file and key.
        SourceError: The CSV file is wrong; the message names file, line and column.
        VehicleFileError: The robot's file is wrong.
    """
    table, path = read_table(mapping), Path(path)
    robot = robot_of(table, Path(mapping).parent, vehicle)
    style = table.table("csv")
    cells = _cells(path, style)
    clock = table.table("time")
    time = _time(cells, clock)
    series = dict(_channels(table, cells, time, robot))
    poses = merge_poses(_poses(table, cells, style, time, robot))
    run = Run(_protocol(table), None, (Lap("none", float(time[0]), float(time[-1])),))
    for used in (clock, style, table):
        used.done()
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
        entry = given[channel]
        column, unit = entry.column("column"), entry.text("unit", "counts", among=UNITS)
        value = cells.numbers(column)
        if entry.switch("increments"):
            value = _accumulated(value, cells, column)
        entry.done()
        yield channel, Series(time, value, unit, f"{cells.path}: column {column}")


def _accumulated(value: Array, cells: CsvTable, column: str | int) -> Array:
    missing = np.flatnonzero(np.isnan(value))
    if len(missing):
        raise SourceError(
            cells.place(int(missing[0]), column), "empty; increments are summed, so none may be missing"
        )
    return np.cumsum(value)


def _poses(
    table: Table, cells: CsvTable, style: Table, time: Array, robot: VehicleParameters
) -> Iterator[Poses]:
    for truck, entry in table.tables("poses", robot.trucks):
        other = entry.text("file", "")
        held = _cells(cells.path.parent / other, style) if other else cells
        clock = entry.table("time")
        when = _time(held, clock) if other or clock.names() else time
        clock.done()
        length, angle = entry.text("length", "m", among=METRES), entry.text("angle", "rad", among=RADIANS)
        factors = (METRES[length], METRES[length], RADIANS[angle])
        pose, sigma = (
            np.column_stack([_optional(held, entry, f"{prefix}{key}") for key in ("x", "y", "theta")])
            * factors
            for prefix in ("", "sigma_")
        )
        entry.done()
        wrong = np.flatnonzero((sigma < 0.0).any(axis=1))
        if len(wrong):
            raise SourceError(f"{held.path}:{held.lines[wrong[0]]}", f"{entry.source}: {EXPECTED_SIGMA}")
        if not np.isfinite(pose).any():
            raise MappingError(entry.source, "no pose in it; expected columns x and y, or theta")
        yield poses_of(truck, when, pose, sigma)


def _optional(cells: CsvTable, table: Table, key: str) -> Array:
    """Return a column `(N,)`; all nan where the mapping names no such column."""
    if key not in table:
        table.number(key, 0.0)  # an optional key
        return np.full(len(cells.rows), np.nan)
    return cells.numbers(table.column(key))
