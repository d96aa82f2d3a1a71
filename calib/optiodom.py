"""Sets of the OptiOdom data, a real robot with motion capture.

A folder holds one `*_metadata.csv` and `*_run-NN.csv` files, gzipped or not: time [s], measured x, y [m] and
theta [rad], and the ticks of the right and the left wheel in that cycle. Diameters stand alike.
Source: Sousa et al., J Intell Robot Syst 105:39 (2022).
"""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from calib.errors import OptiOdomError
from calib.runs import SquareDirection, SquareRun
from vehicle.parameters import ParameterError, Truck
from vehicle.se2 import Array, between


@dataclass(frozen=True, slots=True)
class OptiOdomSet:
    """One set of square runs.

    Attributes:
        truck: the nominal parameters.
        side: of the square [m].
        runs: in the order of their numbers.
    """

    truck: Truck
    side: float
    runs: tuple[SquareRun, ...]


def is_optiodom(folder: Path) -> bool:
    """Return whether a folder looks like an OptiOdom set."""
    return any(folder.glob("*_metadata.csv"))


def read_optiodom(folder: Path | str) -> OptiOdomSet:
    """Return the square runs of an OptiOdom folder of the differential robot.

    The direction of each run is that of its wheels; the set's order, cw first, is not relied on.

    Raises:
        OptiOdomError: it is no such folder, or a file in it is damaged.
    """
    folder = Path(folder)
    metadata = read_metadata(folder)
    kind = metadata.get("type", [""])[0]
    if kind != "diff":
        raise OptiOdomError(folder, f"robot type {kind!r}; UMBmark needs the differential robot, diff")
    side = read_numbers(folder, metadata, "L", 1)[0]
    ticks_per_turn = (
        read_numbers(folder, metadata, "ngear", 1)[0] * read_numbers(folder, metadata, "encRes", 1)[0]
    )
    right, left = read_numbers(folder, metadata, "Di", 2)
    try:
        truck = Truck(read_numbers(folder, metadata, "Li", 1)[0], left, right)
    except ParameterError as error:
        raise OptiOdomError(folder, str(error)) from error
    count = int(read_numbers(folder, metadata, "N", 1)[0])
    files = sorted(folder.glob("*_run-[0-9][0-9].csv*"))
    if len(files) != count:
        raise OptiOdomError(folder, f"{len(files)} runs; expected N = {count} as the metadata says")
    return OptiOdomSet(truck, side, tuple(_run(path, ticks_per_turn) for path in files))


def read_metadata(folder: Path) -> dict[str, list[str]]:
    """Return the cells of a folder's metadata by their keys.

    Raises:
        OptiOdomError: there is not one readable file of them.
    """
    files = sorted(folder.glob("*_metadata.csv"))
    if len(files) != 1:
        raise OptiOdomError(folder, f"{len(files)} files *_metadata.csv; expected one")
    try:
        with files[0].open(encoding="utf-8", newline="") as file:
            return {row[0]: row[1:] for row in csv.reader(file) if row}
    except (OSError, UnicodeDecodeError) as error:
        raise OptiOdomError(files[0], f"cannot be read: {error}") from error


def read_numbers(folder: Path, metadata: dict[str, list[str]], key: str, count: int) -> list[float]:
    """Return the first positive numbers of a key.

    Raises:
        OptiOdomError: there are fewer.
    """
    cells = metadata.get(key, [])[:count]
    try:
        values = [float(cell) for cell in cells]
    except ValueError:
        values = []
    if len(values) < count or not all(math.isfinite(value) and value > 0.0 for value in values):
        hint = "; this is no set of squares" if key == "L" else ""
        raise OptiOdomError(folder, f"metadata {key} = {cells}; expected {count} positive number(s){hint}")
    return values


def _run(path: Path, ticks_per_turn: float) -> SquareRun:
    rows = read_rows(path)
    poses = rows[:, 1:4].copy()
    poses[:, 2] = np.unwrap(poses[:, 2])
    wheel_angles = rows[:, [5, 4]] * (2.0 * math.pi / ticks_per_turn)
    turned = float(np.sum(wheel_angles[:, 1] - wheel_angles[:, 0]))
    direction: SquareDirection = "cw" if turned < 0.0 else "ccw"
    return SquareRun(direction, between(poses[0], poses[-1]), wheel_angles, str(path))


def read_rows(path: Path) -> Array:
    """Return the rows `(N, 6)` of a run.

    Raises:
        OptiOdomError: it is damaged.
    """
    try:
        rows = np.loadtxt(path, delimiter=",", ndmin=2, dtype=np.float64)
    except (OSError, EOFError, ValueError) as error:
        raise OptiOdomError(path, f"damaged: {error}") from error
    if rows.shape[1] != 6 or len(rows) < 2 or not np.isfinite(rows).all():
        raise OptiOdomError(
            path, f"{rows.shape} values; expected rows of t, x, y, theta, right, left, all finite"
        )
    return rows
