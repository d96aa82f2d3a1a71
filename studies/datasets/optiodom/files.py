"""The files of an OptiOdom set: one metadata file, and one file of rows for each run.

A folder holds one `*_metadata.csv` and `*_run-NN.csv` files, gzipped or not: time [s], measured x, y [m] and
theta [rad], and the ticks of the right and the left wheel in that cycle. The metadata, too, state the right
diameter before the left one.
Source: Sousa et al., J Intell Robot Syst 105:39 (2022).
"""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np

from omnimate.files.errors import SourceError
from omnimate.vehicle.se2 import Array


class OptiOdomError(SourceError):
    """A folder that is not the OptiOdom set that was expected, or a damaged file in it."""


def is_optiodom(folder: Path) -> bool:
    """Return whether a folder looks like an OptiOdom set."""
    return any(folder.glob("*_metadata.csv"))


def find_sets(root: Path | str) -> tuple[Path, ...]:
    """Return the folders of all sets under a root, in order.

    Raises:
        OptiOdomError: There is none.
    """
    root = Path(root)
    folders = sorted({file.parent for file in root.rglob("*_metadata.csv") if is_optiodom(file.parent)})
    if not folders:
        raise OptiOdomError(
            root, "no *_metadata.csv under it; expected folders such as diff/square/230620202042"
        )
    return tuple(folders)


def read_metadata(folder: Path) -> dict[str, list[str]]:
    """Return the cells of a folder's metadata by their keys.

    Raises:
        OptiOdomError: There is no such file, there are several, or it cannot be read.
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
    """Return the first `count` numbers of a key, which must be positive.

    Raises:
        OptiOdomError: There are fewer positive numbers.
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


def read_rows(path: Path) -> Array:
    """Return the rows `(N, 6)` of a run.

    Raises:
        OptiOdomError: The file is damaged.
    """
    try:
        rows = np.loadtxt(path, delimiter=",", ndmin=2, dtype=np.float64)
    except (OSError, EOFError, ValueError) as error:
        raise OptiOdomError(path, f"damaged: {error}") from error
    if rows.shape[1] != 6 or len(rows) < 2 or not np.isfinite(rows).all():
        raise OptiOdomError(
            path,
            f"{len(rows)} rows of {rows.shape[1]} values; expected rows of t, x, y, theta, right, left, at "
            "least two, all finite",
        )
    return rows
