"""What is known in the morning after a night's work: of robots, of the floor, and what is uncertain."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from omnimate.fleet.model.histories import History
    from omnimate.vehicle.se2 import Array

RobotState = Literal["fine", "drift", "sick"]
Shape = Literal["step", "ramp"]
PlaceEffect = Literal["loss", "creep"]
SEPARATE = 2.0  # [m] from a place that stands out more, at which another one may be seen
# Logarithm of the e-value from which on a robot is said to drift: at most one healthy robot in twenty reaches
# it (Markov's inequality; an e-value's mean is at most 1).
DRIFT = math.log(20.0)


@dataclass(frozen=True, slots=True)
class Change:
    """What a robot's history shows.

    Attributes:
        robot: Name of the robot.
        kind: Type of the robot.
        log_e: Logarithm of the e-value of any change.
        name: Number that changed most likely.
        share: Probability of that number, given that one changed.
        since: Date from which on, most likely.
        earliest: Date before which it began with a probability below 5 %.
        latest: Date after which it began with a probability below 5 %.
        shape: A step, or a ramp.
        size: Change until the last day [1 or rad].
        sigma: Its standard deviation.
        per_day: Change per day of a ramp; 0 for a step.
    """

    robot: str
    kind: str
    log_e: float
    name: str
    share: float
    since: str
    earliest: str
    latest: str
    shape: Shape
    size: float
    sigma: float
    per_day: float


@dataclass(frozen=True, slots=True)
class BadPlace:
    """A place of the floor where robots lose way, or creep.

    Attributes:
        effect: "loss" of a part of the travel, or "creep" per metre.
        x: [m].
        y: [m].
        reach: Radius, [m].
        covariance: Of x and y [m^2], `(2, 2)`.
        size: Part lost, `(1,)`, or creep along x and y per metre, `(2,)` [1].
        sigma: Standard deviations of the size.
        gain: Twice the gain in log likelihood over no place there.
        crossings: Number of ways over it.
        floor: Name of the floor that it is on; "" for the only one.
        edge: Standard deviation of its edge from crossing to crossing [half cells]; stands in no table.
    """

    effect: PlaceEffect
    x: float
    y: float
    reach: float
    covariance: Array
    size: Array
    sigma: Array
    gain: float
    crossings: int
    floor: str = ""
    edge: float = 0.0

    @property
    def per_crossing(self) -> float:
        """Way lost, or crept, in a mean crossing [m]."""
        size = float(np.hypot(*self.size) if len(self.size) == 2 else self.size[0])
        return size * 0.5 * math.pi * self.reach  # the mean chord of a disc


@dataclass(frozen=True, slots=True)
class Asked:
    """A robot for which triage keeps asking for the same diagnosis.

    Attributes:
        robot: Name of the robot.
        effect: Effect that comes closest.
        component: On which.
        since: Date of the first of the recordings in a row.
    """

    robot: str
    effect: str
    component: str
    since: str


@dataclass(frozen=True, slots=True)
class Judged:
    """A robot that was judged.

    Attributes:
        change: What its history shows, healthy or not.
        asked: What triage keeps asking for; None for nothing.
        is_listed: Whether it is on the night's list.
    """

    change: Change
    asked: Asked | None
    is_listed: bool

    @property
    def state(self) -> RobotState:
        """The robot's state: sick is on the list, drift may be on a later one."""
        if self.is_listed:
            return "sick"
        return "drift" if self.asked is not None or self.change.log_e >= DRIFT else "fine"


@dataclass(frozen=True, slots=True)
class FloorSummary:
    """What is known of one of a fleet's floors.

    Attributes:
        floor: Its name; "" for the only one.
        recordings: Number of recordings within the week.
        roughness: Of the floor beside its bad places [m/sqrt(m)].
    """

    floor: str
    recordings: int
    roughness: float


@dataclass(frozen=True, slots=True)
class Morning:
    """What is known after a night's work.

    Attributes:
        day: Date of the last recordings, YYYY-MM-DD.
        recordings: Number of recordings of that day.
        errors: Those that could not be worked on: robot, recording, why.
        changes: What each robot's history shows, healthy or not.
        sick: The night's list, the clearest first.
        asked: Robots not on the list for which triage keeps asking for the same diagnosis.
        places: Bad places of all floors, those of each floor together, the clearest first.
        floors: The floors, that with most recordings first.
    """

    day: str
    recordings: int
    errors: tuple[tuple[str, str, str], ...]
    changes: tuple[Change, ...]
    sick: tuple[Change, ...]
    asked: tuple[Asked, ...]
    places: tuple[BadPlace, ...]
    floors: tuple[FloorSummary, ...]

    @property
    def roughness(self) -> float:
        """Roughness of the floor with most recordings, beside its bad places [m/sqrt(m)]."""
        return self.floors[0].roughness

    def judged(self) -> list[Judged]:
        """Return all robots that were judged, in the order of their names."""
        listed = {change.robot for change in self.sick}
        asked = {asked.robot: asked for asked in self.asked}
        return [
            Judged(change, asked.get(change.robot), is_listed=change.robot in listed)
            for change in self.changes
        ]


@dataclass(frozen=True, slots=True)
class Night(Morning):
    """What is known after a night's work, with what it was judged from.

    Attributes:
        histories: Of all robots.
        driven: Of each floor, cells that were driven over: x and y [m] and how often, `(N, 3)`.
    """

    histories: tuple[History, ...]
    driven: Mapping[str, Array]
