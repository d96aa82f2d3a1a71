"""Errors of calibration: measurements from which parameters cannot be estimated."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.vehicle.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path


class CalibrationError(InputError):
    """Measurements in a `source` (file, folder or recording) from which no calibration can be calculated."""


class DirectionError(CalibrationError):
    """Runs with a missing direction, or with cw and ccw swapped."""


class FixError(CalibrationError):
    """An absolute pose that is missing, for example before or after a lap."""


class FrozenChannelError(CalibrationError):
    """An encoder of a wheel or joint, `channel`, whose reading is constant while the robot moves."""

    def __init__(self, source: str | Path, channel: str, problem: str) -> None:
        super().__init__(source, f"{channel} {problem}")
        self.channel = channel


class MethodError(CalibrationError):
    """A method of calibration that the data of an experiment do not allow; `problem` says what it needs."""

    def __init__(self, source: str | Path, method: str) -> None:
        self.problem = f"{method} needs the heading of every run, and three runs or more"
        super().__init__(source, f"the method {self.problem}")


class ReturnTableError(CalibrationError):
    """A table of return errors that cannot be read at a line and column, from 1; column None: the line."""

    def __init__(self, source: str | Path, line: int, column: int | None, problem: str) -> None:
        where = f"line {line}" if column is None else f"line {line}, column {column}"
        super().__init__(source, f"{where}: {problem}")
        self.line = line
        self.column = column


class UnobservableError(CalibrationError):
    """Drives that identify none of the parameters, with the `reasons` by the name of each."""

    def __init__(self, source: str | Path, reasons: Mapping[str, str]) -> None:
        words = "; ".join(f"{name}: {reason}" for name, reason in reasons.items())
        super().__init__(
            source,
            f"these drives identify no parameter ({words}); drive squares in both directions, or open "
            "straights and turns on the spot (`omnimate design` compares them)",
        )
        self.reasons = dict(reasons)
