"""The errors of this room: measurements that cannot be a UMBmark experiment, and why."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path


class CalibrationError(OmnimateError):
    """Measurements that do not make a calibration.

    Attributes:
        source: the file, folder or recording that they came from.
    """

    def __init__(self, source: str | Path, problem: str) -> None:
        super().__init__(f"{source}: {problem}")
        self.source = str(source)


class DirectionError(CalibrationError):
    """Runs that miss a direction, or whose cw and ccw are swapped."""


class FixError(CalibrationError):
    """An absolute pose that is needed before or after a lap, and is not there."""


class FrozenChannelError(CalibrationError):
    """An encoder that stands still while the robot moves.

    Attributes:
        channel: of the encoder, as far as it is known: a wheel or a joint.
    """

    def __init__(self, source: str | Path, channel: str, problem: str) -> None:
        super().__init__(source, f"{channel} {problem}")
        self.channel = channel


class OptiOdomError(CalibrationError):
    """A folder that is no OptiOdom set of squares."""


class ReturnTableError(CalibrationError):
    """A table of return errors that cannot be read.

    Attributes:
        line: counted from 1.
        column: counted from 1; None where the whole line is meant.
    """

    def __init__(self, source: str | Path, line: int, column: int | None, problem: str) -> None:
        where = f"line {line}" if column is None else f"line {line}, column {column}"
        super().__init__(source, f"{where}: {problem}")
        self.line = line
        self.column = column


class UnobservableError(CalibrationError):
    """Drives that tell nothing about any parameter.

    Attributes:
        reasons: why, by parameter.
    """

    def __init__(self, source: str | Path, reasons: Mapping[str, str]) -> None:
        words = "; ".join(f"{name}: {reason}" for name, reason in reasons.items())
        super().__init__(
            source,
            f"these drives identify no parameter ({words}); drive squares in both directions, or open "
            "straights and turns on the spot (`omnimate design` compares them)",
        )
        self.reasons = dict(reasons)
