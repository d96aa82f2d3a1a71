"""The errors of effects: what cannot be one, and an effects file that cannot be read."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from pathlib import Path


class EffectError(OmnimateError):
    """An effect that does not exist, or whose parameters or component are impossible."""


class ExpressionError(EffectError):
    """A text that is no formula; it cannot be read at `column`, from 1."""

    def __init__(self, text: str, column: int, problem: str) -> None:
        super().__init__(f"formula {text[:200]!r}, column {column}: {problem}")
        self.text = text
        self.column = column


class EffectsFileError(EffectError):
    """An effects file, `source`, that cannot be read, or whose `entry` describes no effect."""

    def __init__(self, source: Path | str, entry: str, problem: str) -> None:
        super().__init__(f"{source}: {entry}: {problem}")
        self.source = source
        self.entry = entry
