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
MIN_SEPARATION = 2.0  # [m] between a bad place and a stronger one (assumption)
# Logarithm of the e-value from which a robot is reported as drifting. At most one healthy robot in twenty
# reaches it (Markov's inequality: the mean of an e-value is at most 1).
MIN_DRIFT_LOG_E = math.log(20.0)


@dataclass(frozen=True, slots=True)
class Change:
    """The most probable change in a robot's history.

    Attributes:
        robot: Name of the robot.
        kind: Type of the robot.
        log_e: Natural logarithm of the e-value of any change against none.
        name: Name of the quantity that most probably changed, one of `PARAMETERS` or `JOINT_NUMBERS`.
        share: Probability of that quantity, given that one changed [0 to 1].
        since: Most probable date of its beginning, YYYY-MM-DD.
        earliest: 5 % quantile of that date.
        latest: 95 % quantile of that date.
        shape: Step or ramp.
        size: Change until the last day [1 or rad].
        sigma: Its standard deviation [1 or rad].
        per_day: Slope of a ramp [1/day or rad/day]; 0 for a step.
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
        effect: "loss": wheels lose a part of their travel; "creep": trucks shift in one direction, in
            proportion to travel.
        x: X of its centre in the world frame [m].
        y: Y of its centre [m].
        reach: Its radius [m].
        covariance: Covariance of x and y [m^2], `(2, 2)`.
        size: Fraction of the travel that is lost, `(1,)`, or creep along x and y per metre, `(2,)` [1].
        sigma: Standard deviations of `size`, of the same shape.
        gain: Twice the log likelihood ratio of the place against none: chi-squared without a place.
        crossings: Number of segments over it.
        floor: Name of its floor; "" for the only one.
        edge: Standard deviation of its edge from crossing to crossing [half cells]; not stored.
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
        """Travel lost, or shift by creep, in a crossing along the mean chord of the disc [m]."""
        size = float(np.hypot(*self.size) if len(self.size) == 2 else self.size[0])
        return size * 0.5 * math.pi * self.reach  # mean chord of a disc: pi / 2 times its radius


@dataclass(frozen=True, slots=True)
class RepeatedMismatch:
    """A robot for which triage repeats the same mismatch.

    The effect explains it best; `since` is the date of the first of these consecutive recordings, YYYY-MM-DD.
    """

    robot: str
    effect: str
    component: str
    since: str


@dataclass(frozen=True, slots=True)
class JudgedRobot:
    """A robot that was judged.

    `change` is the most probable one in its history, even if that is not significant; `repeated` is the
    mismatch that triage repeats.
    """

    change: Change
    repeated: RepeatedMismatch | None
    is_faulty: bool

    @property
    def state(self) -> RobotState:
        """The robot's state: "sick" if it is faulty, "drift" if it may become so, else "fine"."""
        if self.is_faulty:
            return "sick"
        return "drift" if self.repeated is not None or self.change.log_e >= MIN_DRIFT_LOG_E else "fine"


@dataclass(frozen=True, slots=True)
class FloorSummary:
    """One of a fleet's floors.

    The name is "" for the only one; recordings are those of the week; the roughness is that outside its bad
    places [m/sqrt(m)].
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
        failed: Recordings without results, each as (robot, recording, reason).
        changes: The most probable change of each robot, healthy or faulty.
        faulty: Changes of the faulty robots, the most significant first.
        repeated: Robots that are not faulty, for which triage repeats the same mismatch.
        places: Bad places, by floor, the most significant of each floor first.
        floors: The floors, that with most recordings first.
        histories: Histories of all robots; empty in a report from `report_store.read_report`, where
            `read_history` returns them.
        driven: For each floor, the cells that were driven over: x and y [m] and number of segments, `(N, 3)`;
            empty in a report from `read_report`, where `read_floor` returns them.
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
    """Return the factor by which a quantity is multiplied for display, and the unit of the product."""
    return (math.degrees(1.0), "degrees") if name in JOINT_NUMBERS else (100.0, "%")


def format_onset(change: Change) -> str:
    """Return the date since when, with its 5 % and 95 % quantiles if they differ."""
    if change.earliest == change.latest == change.since:
        return change.since
    return f"{change.since} ({change.earliest} to {change.latest})"


def format_size(change: Change) -> str:
    """Return the size with its 95 % interval, in % or degrees."""
    factor, unit = display_unit(change.name)
    return f"{factor * change.size:+.3f} +- {1.96 * factor * change.sigma:.3f} {unit}"


def format_rate(change: Change) -> str:
    """Return the slope of a ramp per day in % or degrees; `no more` for a step."""
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
    """Return the effect of a place in words, with the direction of a creep."""
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
