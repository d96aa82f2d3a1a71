"""Drives divided into short stretches, and the errors of plain odometry in each.

Each stretch is aligned with its own poses, so that nothing is carried over from one to the next: neither the
start of the truck nor, where no heading is measured, its heading.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.recording.signals import WINDOW, bridged, integrated, poses_at
from omnimate.vehicle.odometry import wheels_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from omnimate.vehicle.parameters import Truck, TruckName
    from omnimate.vehicle.recording import Poses, Recording
    from omnimate.vehicle.se2 import Array

# [s] long enough for travel to exceed a pose's error, short against the heading error of a swapped wheel
STRETCH = 5.0
MIN_POSES = 3  # of a stretch: the alignment alone fits two


@dataclass(frozen=True, slots=True)
class Stretches:
    """All drives of one truck, concatenated, with P poses in stretches."""

    truck: Truck  # the truck as described
    turned: Array  # turns of the left and the right wheel in each step, `(N, 2)` [rad]
    at: Array  # number of steps before each pose, with a fraction, `(P,)`
    position: NDArray[np.complex128]  # x + iy of each pose, `(P,)` [m]
    heading: Array  # heading of each pose; nan where it was not measured, `(P,)` [rad]
    stretch: NDArray[np.int64]  # number of the stretch of each pose, from 0, `(P,)`

    @property
    def count(self) -> int:
        """Number of stretches."""
        return int(self.stretch[-1]) + 1

    @property
    def extent(self) -> float:
        """Root mean square distance of poses from the mean of their stretch, turns included [m]."""
        still = np.zeros(len(self.at))
        rows = self._rows(self.position - self.mean(self.position), self._turns(still))
        return float(np.sqrt((rows**2).sum(axis=1).mean()))

    def missed(self, turned: Array, ratios: Array, scrub: float = 0.0) -> Array:
        """Return errors of odometry at each pose in x, y and heading times half a wheelbase, `(P, 3)` [m].

        Wheels turn by `turned` (N, 2) [rad]. Ratios (3,) are effective over nominal left diameter, right
        diameter and wheelbase, which grows with curvature by `scrub` [m], as in `turn_scrub`.
        """
        left, right = (turned * np.array(self.truck.radii) * ratios[:2]).T
        across, forward = 0.5 * (right - left) / ratios[2], 0.5 * (right + left)
        yaw = 2.0 * across / self.truck.wheelbase
        yaw /= 1.0 + scrub * np.abs(yaw) / np.maximum(np.hypot(forward, across), 1e-12)
        driven = integrated(np.stack([forward, np.zeros_like(yaw), yaw], axis=1), np.zeros(3))
        x, y, heading = poses_at(self.at, np.arange(float(len(driven))), driven).T
        path = x + 1j * y - self.mean(x + 1j * y)
        goal = self.position - self.mean(self.position)
        return self._rows(path * self._aligning(path, goal, heading) - goal, self._turns(heading))

    def mean(self, values: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Return for each pose the mean (P,) of values over its stretch."""
        sums = [np.bincount(self.stretch, weights=part) for part in (values.real, values.imag)]
        means = (sums[0] + 1j * sums[1]) / np.bincount(self.stretch)
        return np.asarray(means[self.stretch])

    def _aligning(
        self, path: NDArray[np.complex128], goal: NDArray[np.complex128], heading: Array
    ) -> NDArray[np.complex128]:
        """Return for each pose the rotation (P,), of modulus 1, that aligns its stretch."""
        measured = np.exp(1j * (self.heading - heading))
        turn = self.mean(np.where(np.isfinite(self.heading), measured, np.conj(path) * goal))
        return np.asarray(turn / np.maximum(np.abs(turn), 1e-12))

    def _turns(self, heading: Array) -> Array:
        """Return headings (P,) minus the measured ones, less the mean of each stretch [rad]."""
        known = np.isfinite(self.heading)
        error = np.exp(1j * np.where(known, heading - self.heading, 0.0))
        return np.asarray(np.where(known, np.angle(error * np.conj(self.mean(error))), 0.0))

    def _rows(self, error: NDArray[np.complex128], turned: Array) -> Array:
        return np.stack([error.real, error.imag, 0.5 * self.truck.wheelbase * turned], axis=1)


def stretches_of(recordings: Sequence[Recording], truck: TruckName) -> Stretches | None:
    """Return the stretches of a truck's drives that have enough poses; None where none has."""
    turned, at, poses, stretch = [], [], [], []
    steps = count = 0
    for recording in recordings:
        angles = [bridged(recording, wheel, recording.wheel_angle(wheel)) for wheel in wheels_of(truck)]
        angle = np.stack(angles, axis=1)
        turned.append(np.diff(angle, axis=0, append=angle[-1:]))
        steps_before, steps = steps, steps + len(recording)
        if recording.poses is None:
            continue
        thinned = _thinned(recording.poses.of(truck), recording.time)
        number = _numbers(thinned.time, recording.time)
        enough = np.bincount(number, minlength=1)[number] >= MIN_POSES
        step = np.interp(thinned.time[enough], recording.time, np.arange(len(recording)))
        at.append(steps_before + step)
        poses.append(thinned.pose[enough])
        names, renumbered = np.unique(number[enough], return_inverse=True)
        stretch.append(count + renumbered)
        count += len(names)
    if count == 0:
        return None
    pose = np.concatenate(poses)
    return Stretches(
        recordings[0].vehicle.trucks[truck],
        np.concatenate(turned),
        np.concatenate(at),
        pose[:, 0] + 1j * pose[:, 1],
        pose[:, 2],
        np.concatenate(stretch),
    )


def _thinned(poses: Poses, clock: Array) -> Poses:
    """Return the poses with known positions within a recording's time, one in each window at most."""
    inside = (poses.time >= clock[0]) & (poses.time <= clock[-1])
    poses = poses.select(np.isfinite(poses.pose[:, :2]).all(axis=1) & inside)
    return poses.select(np.unique(np.floor((poses.time - clock[0]) / WINDOW), return_index=True)[1])


def _numbers(time: Array, clock: Array) -> NDArray[np.int64]:
    """Return the number of the stretch of each time, `(P,)`."""
    span = float(clock[-1] - clock[0])
    count = max(1, round(span / STRETCH))
    number = (time - clock[0]) / max(span, 1e-9) * count
    return np.asarray(np.minimum(number, count - 1).astype(np.int64))
