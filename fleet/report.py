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
    """The most probable change in a robot's history."""

    robot: str  # name of the robot
    kind: str  # type of the robot
    log_e: float  # natural logarithm of the e-value of any change against none
    name: str  # name of the quantity that most probably changed, one of `PARAMETERS` or `JOINT_NUMBERS`
    share: float  # probability of that quantity, given that one changed [0 to 1]
    since: str  # most probable date of its beginning, YYYY-MM-DD
    earliest: str  # 5 % quantile of that date
    latest: str  # 95 % quantile of that date
    shape: Shape  # step or ramp
    size: float  # change until the last day [1 or rad]
    sigma: float  # its standard deviation [1 or rad]
    per_day: float  # slope of a ramp [1/day or rad/day]; 0 for a step


@dataclass(frozen=True, slots=True)
class BadPlace:
    """A place of the floor where robots lose travel, or creep."""

    # "loss": wheels lose a part of their travel; "creep": trucks shift in one direction, in proportion to
    # travel
    effect: PlaceEffect
    x: float  # x of its centre in the world frame [m]
    y: float  # y of its centre [m]
    reach: float  # its radius [m]
    covariance: Array  # covariance of x and y [m^2], `(2, 2)`
    size: Array  # fraction of the travel that is lost, `(1,)`, or creep along x and y per metre, `(2,)` [1]
    sigma: Array  # standard deviations of `size`, of the same shape
    gain: float  # twice the log likelihood ratio of the place against none: chi-squared without a place
    crossings: int  # number of segments over it
    floor: str = ""  # name of its floor; "" for the only one
    edge: float = 0.0  # standard deviation of its edge from crossing to crossing [half cells]; not stored

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
    """The report of one day."""

    day: str  # date of the last recordings, YYYY-MM-DD
    recordings: int  # number of recordings of that day
    failed: tuple[tuple[str, str, str], ...]  # recordings without results, each as (robot, recording, reason)
    changes: tuple[Change, ...]  # the most probable change of each robot, healthy or faulty
    faulty: tuple[Change, ...]  # changes of the faulty robots, the most significant first
    # robots that are not faulty, for which triage repeats the same mismatch
    repeated: tuple[RepeatedMismatch, ...]
    places: tuple[BadPlace, ...]  # bad places, by floor, the most significant of each floor first
    floors: tuple[FloorSummary, ...]  # the floors, that with most recordings first
    # histories of all robots; empty in a report from `report_store.read_report`, where `read_history` returns
    # them
    histories: tuple[History, ...] = ()
    # for each floor, the cells that were driven over: x and y [m] and number of segments, `(N, 3)`; empty in
    # a report from `read_report`, where `read_floor` returns them
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
