"""How far estimates are from the judge's poses along a drive, and how far by their own measure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.vehicle.se2 import between, wrap

if TYPE_CHECKING:
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array

FLOOR = np.array([1e-3, 1e-3, 1e-3])  # [m, m, rad] below which no error counts: a good tracker's scatter
STILL = 2e-3  # [m] of the way within which the poses before a drive are averaged


@dataclass(frozen=True, slots=True)
class Judge:
    """Poses of truck a from outside, from the pose at the start on.

    Attributes:
        time: Time of each pose [s], shape `(K,)`.
        pose: Poses in the frame of the first [m, m, rad], shape `(K, 3)`.
        sigma: Their standard deviations, those of the first pose included, shape `(K, 3)`.
    """

    time: Array
    pose: Array
    sigma: Array


def judge_of(recording: Recording) -> Judge:
    """Return what judges a recording; the poses before it moves are averaged."""
    assert recording.poses is not None
    poses = recording.poses.of("a")
    known = np.isfinite(poses.pose).all(axis=1)
    time, pose, sigma = poses.time[known], poses.pose[known], poses.sigma[known]
    wheels = [recording.wheel_angle(wheel) for wheel in ("a.left", "a.right")]
    rolled = (
        sum(np.abs(angle - angle[0]) for angle in wheels) * recording.vehicle.trucks["a"].wheel_diameter_left
    )
    still = max(1, int(np.searchsorted(time, recording.time[np.argmax(rolled > 4.0 * STILL)])))
    first = np.array([*pose[:still, :2].mean(axis=0), pose[0, 2] + wrap(pose[:still, 2] - pose[0, 2]).mean()])
    own = sigma[0] / np.sqrt(still)
    away = pose - first
    spread = np.hypot(sigma, own)
    spread[:, :2] = np.hypot(spread[:, :2], (own[2] * np.hypot(away[:, 0], away[:, 1]))[:, None])
    return Judge(time, between(first, pose), spread)


def errors_of(judge: Judge, time: Array, path: Array) -> Array:
    """Return judge minus estimate [m, m, rad] at each of the judge's poses, shape `(K, 3)`."""
    from_start = between(path[0], path)
    heading = np.unwrap(from_start[:, 2])
    seen = np.stack(
        [np.interp(judge.time, time, column) for column in (*from_start[:, :2].T, heading)], axis=1
    )
    error = judge.pose - seen
    return np.stack([error[:, 0], error[:, 1], wrap(error[:, 2])], axis=1)


def rms(error: Array) -> float:
    """Return the root mean square of the distance along the drive [m]."""
    return float(np.sqrt(np.mean(error[:, 0] ** 2 + error[:, 1] ** 2)))


def squared(judge: Judge, error: Array, time: Array, sigma: Array) -> Array:
    """Return the squared error in standard deviations, summed over x, y and heading, at each pose `(K,)`."""
    known = np.stack([np.interp(judge.time, time, column) for column in sigma.T], axis=1)
    return np.asarray(np.sum(error**2 / (known**2 + judge.sigma**2 + FLOOR**2), axis=1))


def nees(judge: Judge, error: Array, time: Array, sigma: Array) -> float:
    """Return the mean squared error in standard deviations, summed over x, y and heading: 3 where honest."""
    moved = judge.time > judge.time[0] + 1.0
    return float(np.mean(squared(judge, error, time, sigma)[moved]))
