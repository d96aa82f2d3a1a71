"""`run.toml`: protocol of a drive, side of its square, and laps."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import tomli_w

from omnimate.vehicle.atomic import write_text
from omnimate.vehicle.errors import RecordingError, TableError
from omnimate.vehicle.recording import DIRECTIONS, Lap, Run
from omnimate.vehicle.tables import read_toml

if TYPE_CHECKING:
    from collections.abc import Mapping

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,63}")  # valid name of a floor, usable in URLs and file names


def read_run(path: Path | str) -> Run:
    """Return the content of a `run.toml`.

    Raises:
        RecordingError: The file cannot be read, is not TOML, or a value is missing or impossible.
    """
    try:
        document = read_toml(path)
    except TableError as error:
        raise RecordingError(path, error.problem) from error
    protocol, laps = document.get("protocol"), document.get("lap", [])
    if not isinstance(protocol, str) or not protocol:
        given = repr(protocol) if "protocol" in document else "is missing"
        raise RecordingError(path, f"protocol {given}; expected text such as `umbmark` or `free`")
    if not isinstance(laps, list) or not all(isinstance(lap, dict) for lap in laps):
        raise RecordingError(path, "lap; expected tables written as [[lap]]")
    side = _number(document, "side", path, "side") if "side" in document else None
    if side is not None and side <= 0:
        raise RecordingError(path, f"side {side:g}; expected a length in metres above 0")
    floor = document.get("floor", "")
    if not isinstance(floor, str) or not NAME.fullmatch(floor or "0"):
        raise RecordingError(path, f"floor {floor!r}; expected a name of letters, digits, `.`, `_` and `-`")
    return Run(
        protocol, side, tuple(_lap(lap, path, number) for number, lap in enumerate(laps, start=1)), floor
    )


def write_run(run: Run, path: Path | str) -> None:
    """Write a `run.toml` atomically."""
    document: dict[str, Any] = {"protocol": run.protocol}
    if run.side is not None:
        document["side"] = float(run.side)
    if run.floor:
        document["floor"] = run.floor
    laps = [
        {"direction": lap.direction, "start": float(lap.start), "end": float(lap.end)} for lap in run.laps
    ]
    write_text(Path(path), tomli_w.dumps(document | ({"lap": laps} if laps else {})))


def _lap(table: Mapping[str, Any], path: Path | str, number: int) -> Lap:
    direction = table.get("direction")
    if direction not in DIRECTIONS:
        raise RecordingError(
            path, f"lap {number}: direction {direction!r}; expected one of {', '.join(DIRECTIONS)}"
        )
    start, end = (_number(table, key, path, f"lap {number}: {key}") for key in ("start", "end"))
    if end <= start:
        raise RecordingError(
            path, f"lap {number}: it ends at {end:.6f} s, not after its start at {start:.6f} s"
        )
    return Lap(direction, start, end)


def _number(table: Mapping[str, Any], key: str, path: Path | str, name: str) -> float:
    value, largest = table.get(key), sys.float_info.max
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= largest:
        given = repr(value) if key in table else "is missing"
        raise RecordingError(path, f"{name} {given}; expected a finite number")
    return float(value)
