"""The errors of the motion room."""

from __future__ import annotations

from omnimate.vehicle.errors import OmnimateError


class ProgramError(OmnimateError):
    """A program that no robot can drive.

    Attributes:
        row: First impossible row of the program, counted from 0.
    """

    def __init__(self, row: int, problem: str) -> None:
        super().__init__(f"row {row} of the program: {problem}")
        self.row = row
