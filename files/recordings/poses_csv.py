"""`poses.csv`: absolute poses measured from outside, one per line, unknown values left empty."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from omnimate.vehicle.atomic import write_text
from omnimate.vehicle.errors import RecordingError, describe_read_error
from omnimate.vehicle.parameters import TRUCKS
from omnimate.vehicle.recording import Poses
from omnimate.vehicle.se2 import wrap

if TYPE_CHECKING:
    from collections.abc import Collection

HEADER = "t,body,x,y,theta,sigma_x,sigma_y,sigma_theta"
_NAMES = HEADER.split(",")
EXPECTED_SIGMA = "expected a standard deviation above 0; 0, or none, where it is unknown"
_ROUNDING = 1e-5  # [rad] rounding error of pi written with four decimals


def read_poses(path: Path | str, trucks: Collection[str] = TRUCKS) -> Poses:
    """Return the poses of a `poses.csv` in order of time; `trucks` are the bodies that the robot has.

    Raises:
        RecordingError: The file cannot be read, or a line is wrong; the error names file and line.
    """
    try:
        lines = Path(path).read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise RecordingError(path, f"cannot be read: {describe_read_error(error)}") from error
    if not lines or lines[0].strip() != HEADER:
        raise RecordingError(f"{path}:1", f"expected the header `{HEADER}`")
    numbered = enumerate(lines[1:], start=2)
    rows = [_row(line, f"{path}:{number}", trucks) for number, line in numbered if line.strip()]
    rows.sort(key=lambda row: row[1][0])  # a file may have the poses of each body together
    values = np.array([row[1] for row in rows], np.float64).reshape(-1, 7)
    pose = values[:, 1:4].copy()
    pose[:, 2] = wrap(pose[:, 2])
    return Poses(values[:, 0].copy(), np.array([row[0] for row in rows], "U1"), pose, values[:, 4:7].copy())


def write_poses(poses: Poses, path: Path | str) -> None:
    """Write a `poses.csv` atomically, with full precision and wrapped headings."""
    pose = poses.pose.copy()
    round_about = np.abs(pose[:, 2]) > math.pi
    pose[round_about, 2] = wrap(pose[round_about, 2])
    numbers = np.column_stack((poses.time, pose, poses.sigma)).tolist()
    lines = [HEADER]
    for body, (time, *values) in zip(poses.body.tolist(), numbers, strict=True):
        cells = ["" if math.isnan(value) else repr(value) for value in values]
        lines.append(",".join([repr(time), body, *cells]))
    write_text(Path(path), "\n".join(lines) + "\n")


def _row(line: str, place: str, trucks: Collection[str]) -> tuple[str, list[float]]:
    """Return the body and the seven numbers of a line."""
    cells = [cell.strip() for cell in line.split(",")]
    if len(cells) != len(_NAMES):
        raise RecordingError(place, f"{len(cells)} columns; expected the {len(_NAMES)} of `{HEADER}`")
    if cells[1] not in trucks:
        raise RecordingError(place, f"body {cells[1]!r}; this robot has {' and '.join(sorted(trucks))}")
    if not cells[0]:
        raise RecordingError(place, "t is empty; every pose has its time")
    values = [_number(cell, name, place) for name, cell in zip(_NAMES, cells, strict=True) if name != "body"]
    if abs(values[3]) > math.pi + _ROUNDING:
        raise RecordingError(place, f"theta {cells[4]} is outside (-pi, pi]; it is an angle in radians")
    for name, value in zip(_NAMES[-3:], values[-3:], strict=True):
        if value < 0:
            raise RecordingError(place, f"{name} {value:g}; {EXPECTED_SIGMA}")
    return cells[1], values


def _number(cell: str, name: str, place: str) -> float:
    """Return a cell's number; nan where it is empty."""
    if not cell:
        return math.nan
    try:
        value = float(cell)
    except ValueError:
        raise RecordingError(place, f"{name} {cell!r} is not a number") from None
    if not math.isfinite(value):
        raise RecordingError(
            place, f"{name} {cell!r} is not finite; leave the cell empty where it is unknown"
        )
    return value
