"""Drives cut into short stretches, and how far plain odometry misses the poses of each.

A stretch is laid onto its own poses, so that nothing is carried from one to the next: neither where the truck
starts nor, where no heading is measured, which way it looks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.recording.signals import WINDOW, angle_of, integrated

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from omnimate.vehicle.parameters import Truck, TruckName
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array

STRETCH = 5.0  # [s] long against a pose's error, short against what a swapped wheel makes of a heading
_LEAST = 3  # poses in a stretch from which it tells anything


@dataclass(frozen=True, slots=True)
class Stretches:
    """One truck's drives, end to end, with P poses in stretches.

    Attributes:
        truck: as described.
        turned: (N, 2) turns of the left and the right wheel in each step [rad].
        at: (P,) steps that were made when a pose was measured, with a fraction.
        position: (P,) x + iy [m].
        heading: (P,) [rad]; nan where it was not measured.
        stretch: (P,) number of the stretch, counted from 0.
    """

    truck: Truck
    turned: Array
    at: Array
    position: NDArray[np.complex128]
    heading: Array
    stretch: NDArray[np.int64]

    @property
    def count(self) -> int:
        """How many stretches there are."""
        return int(self.stretch[-1]) + 1

    @property
    def extent(self) -> float:
        """Root mean square distance of poses from the middle of their stretch, turns counted [m]."""
        still = np.zeros(len(self.at))
        rows = self._rows(self.position - self.mean(self.position), self._turns(still))
        return float(np.sqrt((rows**2).sum(axis=1).mean()))

    def missed(self, turned: Array, ratios: Array, scrub: float = 0.0) -> Array:
        """Return what odometry misses at each pose (P, 3): x, y, and the way of a wheel about the middle [m].

        Args:
            turned: (N, 2) of the left and the right wheel [rad].
            ratios: (3,) effective over nominal left diameter, right diameter, wheelbase.
            scrub: growth of the wheelbase per curvature [m], as `turn_scrub` has it.
        """
        radii = 0.5 * np.array([self.truck.wheel_diameter_left, self.truck.wheel_diameter_right])
        left, right = (turned * radii * ratios[:2]).T
        across, forward = 0.5 * (right - left) / ratios[2], 0.5 * (right + left)
        yaw = 2.0 * across / self.truck.wheelbase
        yaw /= 1.0 + scrub * np.abs(yaw) / np.maximum(np.hypot(forward, across), 1e-12)
        driven = integrated(np.stack([forward, np.zeros_like(yaw), yaw], axis=1), np.zeros(3))
        x, y, heading = (np.interp(self.at, np.arange(len(driven)), one) for one in driven.T)
        way = x + 1j * y - self.mean(x + 1j * y)
        goal = self.position - self.mean(self.position)
        return self._rows(way * self._laid(way, goal, heading) - goal, self._turns(heading))

    def mean(self, values: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Return of each pose the mean (P,) of values over its stretch."""
        sums = [np.bincount(self.stretch, weights=one) for one in (values.real, values.imag)]
        means = (sums[0] + 1j * sums[1]) / np.bincount(self.stretch)
        return np.asarray(means[self.stretch])

    def _laid(
        self, way: NDArray[np.complex128], goal: NDArray[np.complex128], heading: Array
    ) -> NDArray[np.complex128]:
        """Return of each pose the turn (P,), of length 1, that lays its stretch onto what was measured."""
        seen = np.exp(1j * (self.heading - heading))
        turn = self.mean(np.where(np.isfinite(self.heading), seen, np.conj(way) * goal))
        return np.asarray(turn / np.maximum(np.abs(turn), 1e-12))

    def _turns(self, heading: Array) -> Array:
        """Return by how much headings (P,) differ from the measured ones, means of stretches apart [rad]."""
        known = np.isfinite(self.heading)
        off = np.exp(1j * np.where(known, heading - self.heading, 0.0))
        return np.asarray(np.where(known, np.angle(off * np.conj(self.mean(off))), 0.0))

    def _rows(self, off: NDArray[np.complex128], turned: Array) -> Array:
        return np.stack([off.real, off.imag, 0.5 * self.truck.wheelbase * turned], axis=1)


def stretches_of(recordings: Sequence[Recording], truck: TruckName) -> Stretches | None:
    """Return the stretches of a truck's drives that have poses enough; None where none has."""
    turned, at, poses, stretch = [], [], [], []
    steps = count = 0
    for one in recordings:
        wheels = [wheel for wheel in one.vehicle.wheels if wheel.startswith(truck)]
        angle = np.stack([angle_of(one, wheel) for wheel in wheels], axis=1)
        turned.append(np.diff(angle, axis=0, append=angle[-1:]))
        time, pose = _thinned(one, truck)
        number = _numbers(time, one.time)
        enough = np.bincount(number, minlength=1)[number] >= _LEAST
        at.append(steps + np.interp(time[enough], one.time, np.arange(len(one.time))))
        poses.append(pose[enough])
        own = np.unique(number[enough], return_inverse=True)[1]
        stretch.append(count + own)
        count += int(own.max()) + 1 if len(own) else 0
        steps += len(one.time)
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


def _thinned(recording: Recording, truck: TruckName) -> tuple[Array, Array]:
    """Return the times (P,) and poses (P, 3) of a truck, no denser than the windows, positions known."""
    if recording.poses is None:
        return np.zeros(0), np.zeros((0, 3))
    own, time = recording.poses.of(truck), recording.time
    known = np.isfinite(own.pose[:, :2]).all(axis=1) & (own.time >= time[0]) & (own.time <= time[-1])
    first = np.unique(np.floor((own.time[known] - time[0]) / WINDOW), return_index=True)[1]
    return own.time[known][first], own.pose[known][first]


def _numbers(time: Array, clock: Array) -> NDArray[np.int64]:
    """Return the number of the stretch that each time (P,) lies in."""
    span = float(clock[-1] - clock[0])
    count = max(1, round(span / STRETCH))
    number = (time - clock[0]) / max(span, 1e-9) * count
    return np.asarray(np.minimum(number, count - 1).astype(np.int64))
