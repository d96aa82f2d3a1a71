"""An audit of names that were reported in place of the truth, by the engine that concealed it.

The same robot is driven again, with the same random numbers and the reported effect as its fault. The
difference of this drive from the one with the true fault is compared with the difference between healthy
drives with different random numbers.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from omnimate.vehicle.linkage import linkage_of
from omnimate.vehicle.se2 import wrap
from studies.mismatch.engines.scene import Case, scene, seed_of
from studies.mismatch.engines.vocabulary import Array
from studies.mismatch.engines.writing import Log, Robot, seen
from studies.mismatch.scoring.judging import ASSERTED, UNNAMED, asserted, first_exact, first_right, names_of


@dataclass(frozen=True, slots=True)
class Question:
    name: str  # name of the case
    case: Case  # the case
    seed: int  # seed of the case
    reported: Sequence[Mapping[str, Any]]  # findings that an answer asserts
    right: bool  # whether the answer counts as right


@dataclass(frozen=True, slots=True)
class Audit:
    """Distances between drives, over that of two healthy drives; up to 1.0 no recording can show them."""

    name: str  # name of the case
    truth: str  # effect and component of the true fault
    reported: str  # effects and components that were reported
    right: bool  # whether the answer counts as right
    truth_alone: float  # distance of the drive with the true fault from the healthy one
    left: float  # distance of the drive with the true fault from that with the reported effects


def questions(
    labels: Mapping[str, Any], answers: Mapping[str, Any], cases: Sequence[Case], seed: int
) -> list[Question]:
    """Return what to audit of the engine's corpus: single effects that were reported by another name."""
    asked = []
    for name, label in labels.items():
        answer = answers.get(name)
        if label["kind"] != "single" or not answer or not answer["findings"] or first_exact(label, answer):
            continue
        reported, number = asserted(answer, ASSERTED), int(name.rpartition("-")[2])
        is_driveable = all(key[0] not in UNNAMED and key[1] != "poses" for key in names_of(reported))
        if reported and is_driveable:
            right = first_right(label, answer)
            asked.append(Question(name, cases[number], seed_of(seed, number), reported, right))
    return asked


def audited(question: Question) -> Audit:
    """Return how far the reported effects are from the truth."""
    case, setting = question.case, scene(question.case, question.seed)
    reported = []
    for finding in question.reported:
        values = {name: parameter["value"] for name, parameter in finding["parameters"].items()}
        reported.append(
            setting.fault(finding["effect"], finding["component"], {**finding["where"], **values})
        )
    drives = (
        setting.driven(setting.faults),
        setting.driven(reported),
        setting.driven([]),
        setting.driven([], np.random.default_rng([question.seed, 78])),
    )
    truth, instead, healthy, other = (_missed(setting.robot, drive, case.poses) for drive in drives)
    usual = np.sqrt(np.mean((other - healthy) ** 2, axis=0))
    ((effect, component),) = case.effects
    return Audit(
        question.name,
        f"{effect} {component}",
        " + ".join(f"{finding['effect']} {finding['component']}" for finding in question.reported),
        question.right,
        _largest(truth - healthy, usual),
        _largest(truth - instead, usual),
    )


def _largest(difference: Array, usual: Array) -> float:
    """Return the rms of a difference `(N, K)` over the usual one `(K,)`, of the worst channel."""
    return float(np.max(np.sqrt(np.mean(difference**2, axis=0)) / usual))


def _missed(robot: Robot, log: Log, poses: str) -> Array:
    """Return the errors of plain odometry against the linkage's readings and the true poses, shape `(N, K)`.

    Poses are compared only where a reader of the recording sees some [rad, m].
    """
    view = seen(robot, log, None, None)
    reckoned = np.stack([view.path(truck) for truck in range(robot.trucks)], axis=1)
    missed = []
    if robot.trucks == 2:
        reckoned[:, 1, 0] -= robot.length
        joint_a, joint_b, length = linkage_of(reckoned[:, 0], reckoned[:, 1])
        turned = (wrap(view.reading[:, at] - joint) for at, joint in enumerate((joint_a, joint_b)))
        missed = [*turned, view.reading[:, 2] - length]
    for truck in range({"none": 0, "sonar": 1}.get(poses, robot.trucks)):
        missed += list((log.poses[:, truck] - reckoned[:, truck]).T)
    return np.stack(missed, axis=1)
