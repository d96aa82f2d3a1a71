"""The daily report: faulty robots, bad places and floors, with their uncertainty, and its sentences."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np

from omnimate.fleet.segments import JOINT_NUMBERS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from omnimate.fleet.model.histories import History
    from omnimate.vehicle.se2 import Array

RobotState = Literal["fine", "drift", "sick"]
Shape = Literal["step", "ramp"]
PlaceEffect = Literal["loss", "creep"]
MIN_SEPARATION = 2.0  # [m] from a place that stands out more, at which another one may be found
# Logarithm of the e-value from which on a robot is said to drift: at most one healthy robot in twenty reaches
# it (Markov's inequality; an e-value's mean is at most 1).
DRIFT = math.log(20.0)


@dataclass(frozen=True, slots=True)
class Change:
    """The likeliest change in a robot's history.

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
    """A place of the floor where robots lose travel, or creep.

    Attributes:
        effect: "loss" of a part of the travel, or "creep" per metre.
        x: [m].
        y: [m].
        reach: Radius, [m].
        covariance: Of x and y [m^2], `(2, 2)`.
        size: Part lost, `(1,)`, or creep along x and y per metre, `(2,)` [1].
        sigma: Standard deviations of the size.
        gain: Twice the gain in log likelihood over no place there.
        crossings: Number of segments over it.
        floor: Name of the floor that it is on; "" for the only one.
        edge: Standard deviation of its edge from crossing to crossing [half cells]; in no table.
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
        """Travel lost, or crept, in a mean crossing [m]."""
        size = float(np.hypot(*self.size) if len(self.size) == 2 else self.size[0])
        return size * 0.5 * math.pi * self.reach  # the mean chord of a disc


@dataclass(frozen=True, slots=True)
class RepeatedMismatch:
    """A robot for which triage repeats the same mismatch.

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
class JudgedRobot:
    """A robot that was judged.

    Attributes:
        change: The likeliest change in its history, also of a healthy robot.
        repeated: The mismatch that triage repeats; None for none.
        is_faulty: Whether it is among the report's faulty robots.
    """

    change: Change
    repeated: RepeatedMismatch | None
    is_faulty: bool

    @property
    def state(self) -> RobotState:
        """The robot's state: "sick" is faulty, "drift" may be so in a later report."""
        if self.is_faulty:
            return "sick"
        return "drift" if self.repeated is not None or self.change.log_e >= DRIFT else "fine"


@dataclass(frozen=True, slots=True)
class FloorSummary:
    """One of a fleet's floors.

    Attributes:
        floor: Its name; "" for the only one.
        recordings: Number of recordings within the week.
        roughness: Of the floor outside its bad places [m/sqrt(m)].
    """

    floor: str
    recordings: int
    roughness: float


@dataclass(frozen=True, slots=True)
class DailyReport:
    """The report of one day.

    Attributes:
        day: Date of the last recordings, YYYY-MM-DD.
        recordings: Number of recordings of that day.
        failed: Those without results: robot, recording, why.
        changes: The likeliest change of each robot, healthy or not.
        faulty: Changes of the faulty robots, the clearest first.
        repeated: Robots that are not faulty for which triage repeats the same mismatch.
        places: Bad places of all floors, those of each floor together, the clearest first.
        floors: The floors, that with most recordings first.
        histories: Of all robots; in a report that was read: none, `report_store.read_history` has them.
        driven: Of each floor, cells that were driven over, x and y [m] and how often, `(N, 3)`; in a report
            that was read: none, `report_store.read_floor` has them.
    """

    day: str
    recordings: int
    failed: tuple[tuple[str, str, str], ...]
    changes: tuple[Change, ...]
    faulty: tuple[Change, ...]
    repeated: tuple[RepeatedMismatch, ...]
    places: tuple[BadPlace, ...]
    floors: tuple[FloorSummary, ...]
    histories: tuple[History, ...] = ()
    driven: Mapping[str, Array] = field(default_factory=dict)

    @property
    def roughness(self) -> float:
        """Roughness of the floor with most recordings, outside its bad places [m/sqrt(m)]."""
        return self.floors[0].roughness

    def judged(self) -> list[JudgedRobot]:
        """Return all robots that were judged, in the order of `changes`."""
        faulty = {change.robot for change in self.faulty}
        repeated = {mismatch.robot: mismatch for mismatch in self.repeated}
        return [
            JudgedRobot(change, repeated.get(change.robot), is_faulty=change.robot in faulty)
            for change in self.changes
        ]


def display_unit(name: str) -> tuple[float, str]:
    """Return the factor by which a number is multiplied for display, and the unit of the product."""
    return (math.degrees(1.0), "degrees") if name in JOINT_NUMBERS else (100.0, "%")


def format_onset(change: Change) -> str:
    """Return since when, with the other days on which it may have begun."""
    if change.earliest == change.latest == change.since:
        return change.since
    return f"{change.since} ({change.earliest} to {change.latest})"


def format_size(change: Change) -> str:
    """Return by how much, with its 95 % interval, in % or degrees."""
    factor, unit = display_unit(change.name)
    return f"{factor * change.size:+.3f} +- {1.96 * factor * change.sigma:.3f} {unit}"


def format_rate(change: Change) -> str:
    """Return how much worse it gets in a day."""
    factor, unit = display_unit(change.name)
    return f"{factor * change.per_day:+.3f} {unit}" if change.shape == "ramp" else "no more"


def describe_change(change: Change) -> str:
    """Return a robot's change as a sentence."""
    worse = f", {format_rate(change)} a day" if change.shape == "ramp" else ""
    return (
        f"{change.robot}: {change.name} changed by {format_size(change)} since {format_onset(change)}{worse}"
    )


def describe_mismatch(mismatch: RepeatedMismatch) -> str:
    """Return a mismatch that triage repeats as a sentence."""
    return (
        f"{mismatch.robot}: triage asks for the same diagnosis since {mismatch.since}: "
        f"{mismatch.effect} of {mismatch.component}"
    )


def describe_effect(place: BadPlace) -> str:
    """Return the effect of a place, with the direction of a creep."""
    if place.effect == "loss":
        return "travel is lost"
    return f"robots creep to {math.degrees(math.atan2(place.size[1], place.size[0])):.0f} degrees"


def describe_place(place: BadPlace) -> str:
    """Return a bad place as a sentence."""
    on = f"floor {place.floor}, " if place.floor else ""
    return (
        f"{on}at x {place.x:.2f} m, y {place.y:.2f} m: {describe_effect(place)}, "
        f"{1e3 * place.per_crossing:.1f} mm in a crossing, {place.crossings} crossings"
    )
