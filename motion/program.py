"""A program: a table of motions with laps, executed by compiled code.

Places and headings of a row are given in a frame: the world, in which odometry was initialised, or the
pose at which a lap began. A row that stands still at its end is finished only when all wheels do.
"""

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from omnimate.vehicle.compiled import Record, layout
from omnimate.vehicle.errors import OmnimateError
from omnimate.vehicle.recording import Direction

Follower = Literal["car", "parallel"]

REST, LINE, ARC, TURN, PASS, GOTO = range(6)
KEEP, HERE, WORLD = range(3)


class ProgramError(OmnimateError):
    """A program that no robot can drive; `row` is its first impossible row, counted from 0."""

    def __init__(self, row: int, problem: str) -> None:
        super().__init__(f"row {row} of the program: {problem}")
        self.row = row


class Row(NamedTuple):
    """One step of a program."""

    kind: int  # REST, LINE, ARC, TURN, PASS or GOTO
    x: float = 0.0  # X of the line's end, the arc's centre, the via-point or the goal [m]
    y: float = 0.0  # Y of the line's end, the arc's centre, the via-point or the goal [m]
    heading: float = 0.0  # course of a line; heading at the end of a turn (unwrapped) or at the goal [rad]
    reverse: int = 0  # 1 where a line is driven backwards
    curvature: float = 1.0  # of an arc, positive to the left; else the sharpest that is allowed [1/m]
    length: float = 0.0  # length of an arc [m]
    tolerance: float = 0.0  # distance from a via-point at which the next row begins [m]
    speed: float = 0.0  # speed of the truck's centre, or of the wheels in a turn on the spot [m/s]
    corner_speed: float = 0.0  # speed to which a via-point slows the truck down [m/s]
    duration: float = 0.0  # duration of a rest, counted from standstill [s]
    fix: int = 0  # 1 where an absolute fix is due in the middle of a rest
    truck: int = 0  # 0 to move truck a, 1 to move truck b alone (GOTO)
    frame: int = KEEP  # KEEP the one before, begin a new one HERE, or go back to the WORLD
    lap: int = -1  # number of the lap that the row belongs to; -1 between laps


@dataclass(frozen=True, slots=True)
class Program:
    """A program of motions.

    Raises:
        ProgramError: A row could not be finished, or the side of a square is not above 0.
    """

    protocol: str  # protocol as in `run.toml`: umbmark, extended-umbmark, straight, free
    rows: tuple[Row, ...]  # the rows in the order in which they are driven
    directions: tuple[Direction, ...]  # direction of each lap
    side: float | None = None  # side of the square [m]; None where no square is driven
    follower: Follower = "car"  # control law of truck b

    def __post_init__(self) -> None:
        if self.side is not None and not self.side > 0.0:
            raise ProgramError(0, f"a square of {self.side} m; expected more than 0")
        for number, row in enumerate(self.rows):
            _check(number, row)

    @property
    def table(self) -> Record:
        """The rows as one record array `(R,)`."""
        return np.array([tuple(row) for row in self.rows], layout(Row))


def _check(number: int, row: Row) -> None:
    """Raise an error if a row could never be finished."""
    if not all(map(math.isfinite, row)):
        raise ProgramError(number, f"{row} holds a number that is not finite")
    if row.kind != REST and row.speed <= 0.0:
        raise ProgramError(number, f"a speed of {row.speed} m/s; expected more than 0")
    if row.kind == PASS and min(row.tolerance, row.corner_speed, row.curvature) <= 0.0:
        raise ProgramError(
            number, "tolerance, corner speed and curvature of a via-point; expected more than 0"
        )
    if row.kind == ARC and row.curvature == 0.0:
        raise ProgramError(number, "an arc without curvature; use a line")


def rest(duration: float, *, fix: bool = False) -> Row:
    """Return a row that stands still for a time [s], with an absolute fix in the middle on request."""
    return Row(REST, duration=duration, fix=int(fix))


def in_lap(lap: int, rows: list[Row], frame: int = KEEP) -> list[Row]:
    """Return rows as those of one lap; the first of them sets the frame."""
    return [row._replace(lap=lap, frame=KEEP if number else frame) for number, row in enumerate(rows)]
