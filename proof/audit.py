"""An audit of names that were told in the truth's place, by the engine that concealed it.

The same robot is driven again, by the same chance, with what was told for a fault. What its recording
differs by from the one with the truth in it is held against what healthy drives differ by from day to day.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from proof.cases import seed_of
from proof.robots import LINKAGE, WHEELS
from proof.scene import scene
from proof.score import ASSERTED, asserted, first_exact, first_right

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from proof.cases import Case
    from proof.engine import Drive
    from proof.robots import Robot

    Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Question:
    """What to audit.

    Attributes:
        name: of the case.
        case: itself.
        seed: of it.
        told: what an answer asserts.
        right: whether it counts as right.
    """

    name: str
    case: Case
    seed: int
    told: Sequence[Mapping[str, Any]]
    right: bool


@dataclass(frozen=True, slots=True)
class Audit:
    """How far a name leads, in units of what healthy drives differ by from day to day; 1.0 cannot be told.

    Attributes:
        name: of the case.
        truth: effect and component.
        told: likewise.
        right: whether it counts as right.
        truth_alone: by how much the truth differs from a healthy robot.
        left: by how much it differs from what was told.
    """

    name: str
    truth: str
    told: str
    right: bool
    truth_alone: float
    left: float


def questions(
    labels: Mapping[str, Any], answers: Mapping[str, Any], cases: Sequence[Case], seed: int
) -> list[Question]:
    """Return what to audit of the engine's corpus: single effects of which another name was told first."""
    found = []
    for name, label in labels.items():
        answer = answers.get(name)
        if label["kind"] != "single" or not answer or not answer["findings"] or first_exact(label, answer):
            continue
        told, number = asserted(answer, ASSERTED), int(name.rpartition("-")[2])
        if told and all(_redriven(one) for one in told):
            right = first_right(label, answer)
            found.append(Question(name, cases[number], seed_of(seed, number), told, right))
    return found


def _redriven(finding: Mapping[str, Any]) -> bool:
    """Say whether the engine can drive what a finding says."""
    return bool(finding["effect"] != "unknown" and finding["component"] != "poses")


def audited(question: Question) -> Audit:
    """Return how far what was told leads from the truth."""
    case, own = question.case, scene(question.case, question.seed)
    told = []
    for one in question.told:
        values = {name: parameter["value"] for name, parameter in one["parameters"].items()}
        told.append(own.fault(one["effect"], one["component"], {**one["where"], **values}))
    other_day = np.random.default_rng([question.seed, 78])
    drives = own.driven(own.faults), own.driven(told), own.driven([]), own.driven([], other_day)
    truth, instead, healthy, other = (_missed(own.robot, one, case.poses) for one in drives)
    usual = np.sqrt(np.mean((other - healthy) ** 2, axis=0))
    ((effect, component),) = case.effects
    return Audit(
        question.name,
        f"{effect} {component}",
        " + ".join(f"{one['effect']} {one['component']}" for one in question.told),
        question.right,
        _largest(truth - healthy, usual),
        _largest(truth - instead, usual),
    )


def _largest(difference: Array, usual: Array) -> float:
    """Return the root mean square of a difference `(N, K)` in usual ones `(K,)`, of the worst channel."""
    return float(np.max(np.sqrt(np.mean(difference**2, axis=0)) / usual))


def _missed(robot: Robot, drive: Drive, poses: str) -> Array:
    """Return what plain odometry misses of the linkage's readings, and of poses where some were measured.

    `(N, K)` [rad, m]; of counts and measured poses alone, as whoever reads the recording sees it.
    """
    turned = {
        device.channel: device.sign * (drive.counts[:, number] - device.zero) / device.resolution
        for number, device in enumerate(robot.devices)
    }
    reckoned = _reckoned(robot, turned)
    missed = []
    if robot.trucks == 2:
        gap = reckoned[:, 0, :2] - reckoned[:, 1, :2]
        along = np.arctan2(gap[:, 1], gap[:, 0])
        joints = [
            _wrapped(2.0 * np.pi * turned[channel] - (reckoned[:, truck, 2] - along))
            for truck, channel in enumerate(LINKAGE[:2])
        ]
        missed += [*joints, turned["link"] + robot.length - np.hypot(gap[:, 0], gap[:, 1])]
    seen = {"none": 0, "sonar": 1}.get(poses, robot.trucks)
    for truck in range(seen):
        missed += list((drive.poses[:, truck] - reckoned[:, truck]).T)
    return np.stack(missed, axis=1)


def _reckoned(robot: Robot, turned: Mapping[str, Array]) -> Array:
    """Return poses (N, T, 3) by odometry with the owner's numbers, from turns of the wheels."""
    count = len(next(iter(turned.values())))
    poses = np.zeros((count, robot.trucks, 3))
    for truck in range(robot.trucks):
        left, right = (
            2.0 * np.pi * robot.radius[wheel] * np.diff(turned[WHEELS[wheel]])
            for wheel in (2 * truck, 2 * truck + 1)
        )
        yaw = (right - left) / robot.wheelbase[truck]
        heading = np.concatenate(([0.0], np.cumsum(yaw)))
        middle = heading[:-1] + 0.5 * yaw
        way = 0.5 * (left + right)
        poses[1:, truck, 0] = np.cumsum(way * np.cos(middle))
        poses[1:, truck, 1] = np.cumsum(way * np.sin(middle))
        poses[:, truck, 2] = heading
    if robot.trucks == 2:
        poses[:, 1, 0] -= robot.length
    return poses


def _wrapped(angle: Array) -> Array:
    return np.asarray((angle + np.pi) % (2.0 * np.pi) - np.pi)
