"""From the numbers of recordings to the histories of robots, day by day."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import date
from typing import TYPE_CHECKING

import numpy as np

from omnimate.fleet.joints import JOINT_NUMBERS, NO_JOINTS
from omnimate.fleet.model.histories import History
from omnimate.fleet.segments import PARAMETERS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.fleet.joints import Joints
    from omnimate.fleet.model.evidence import Evidence
    from omnimate.vehicle.parameters import VehicleParameters
    from omnimate.vehicle.se2 import Array


@dataclass(frozen=True, slots=True)
class Day:
    """What one recording says of its robot, beside the floor.

    Attributes:
        robot: Name of the robot.
        kind: Type of the robot.
        day: Date, YYYY-MM-DD.
        information: On `PARAMETERS`, `(3, 3)`.
        score: Likewise, `(3,)`.
        joints: Of the linkage.
    """

    robot: str
    kind: str
    day: str
    information: Array
    score: Array
    joints: Joints = NO_JOINTS


def kind_of(vehicle: VehicleParameters) -> str:
    """Return the type of a robot: those of one size, with or without a linkage."""
    truck = vehicle.trucks["a"]
    mean = 0.5 * (truck.wheel_diameter_left + truck.wheel_diameter_right)
    linkage = "" if vehicle.linkage is None else f", link {vehicle.linkage.length:.1f} m"
    return f"wheelbase {truck.wheelbase:.2f} m, wheels {mean:.2f} m{linkage}"


def day_of(evidence: Evidence, floor: Array, joints: Joints = NO_JOINTS) -> Day:
    """Return what a recording says of its robot.

    Args:
        evidence: Of the recording.
        floor: What known places make of its residuals, `(3 S,)`.
        joints: Of the linkage.
    """
    information, score = evidence.robot_information(floor)
    return Day(evidence.robot, evidence.kind, evidence.day, information, score, joints)


def histories_of(days: Sequence[Day]) -> list[History]:
    """Return the histories of all robots; recordings of one robot on one day are taken together.

    A day whose recordings do not identify the robot's parameters is left out.
    """
    robots: dict[str, dict[str, list[Day]]] = {}
    for single in days:
        robots.setdefault(single.robot, {}).setdefault(single.day, []).append(single)
    if not robots:
        return []
    first = min(date.fromisoformat(single.day) for single in days)
    histories = (_history(by_day, first) for _, by_day in sorted(robots.items()))
    return [history for history in histories if history is not None]


def _history(by_day: dict[str, list[Day]], first: date) -> History | None:
    """Return one robot's history since the first date of the fleet; None where no day says enough."""
    rows = {day: _numbers(parts) for day, parts in sorted(by_day.items())}
    known = {day: row for day, row in rows.items() if row is not None}
    if not known:
        return None
    robot = next(iter(by_day.values()))[0]
    size = max(len(value) for value, _ in known.values())
    known = {day: row for day, row in known.items() if len(row[0]) == size}
    names = PARAMETERS if size == len(PARAMETERS) else (*PARAMETERS, *JOINT_NUMBERS)
    return History(
        robot.robot,
        robot.kind,
        names,
        tuple(known),
        np.array([float((date.fromisoformat(day) - first).days) for day in known]),
        np.array([value for value, _ in known.values()]),
        np.array([covariance for _, covariance in known.values()]),
    )


def _numbers(parts: Sequence[Day]) -> tuple[Array, Array] | None:
    """Return a day's numbers `(P,)` and their covariance `(P, P)`; None where it does not identify them."""
    information = np.sum([part.information for part in parts], axis=0)
    if not np.isfinite(information).all() or np.linalg.cond(information) > 1e12:
        return None
    covariance = np.linalg.inv(information)
    value = covariance @ np.sum([part.score for part in parts], axis=0)
    joints = [part.joints for part in parts if len(part.joints.bias)]
    if not joints:
        return value, covariance
    weights = np.array([single.sigma**-2.0 for single in joints])
    biases = np.array([single.bias for single in joints])
    whole = np.zeros((len(value) + 2, len(value) + 2))
    whole[:-2, :-2] = covariance
    whole[-2:, -2:] = np.diag(1.0 / weights.sum(axis=0))
    return np.concatenate([value, (weights * biases).sum(axis=0) / weights.sum(axis=0)]), whole
