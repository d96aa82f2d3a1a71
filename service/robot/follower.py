"""Where the robot is: plain odometry of every truck at once; IPEC and the filter when they are loaded."""

from __future__ import annotations

import gc
import threading
from typing import TYPE_CHECKING, Any

import numpy as np

from motion.reading import LinkReader
from vehicle.odometry import Odometer
from vehicle.parameters import WHEELS
from vehicle.se2 import wrap

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ipec.tracker import Tracker
    from vehicle.parameters import VehicleParameters
    from vehicle.sample import Sample

LOADING = 3  # samples after which everything that a tracker calls has been loaded


class Follower:
    """Takes every sample of a robot; for one thread.

    The tracker's compiled code is loaded in a thread of its own, which on a new machine takes half a minute;
    until then plain odometry is all there is, and no sample is late for it.
    """

    def __init__(self, vehicle: VehicleParameters) -> None:
        self._odometers = {truck: Odometer(vehicle, truck) for truck in vehicle.trucks}
        self._link = LinkReader(vehicle)
        self._joints: tuple[float, float, float] | None = None
        self._tracker: Tracker | None = None
        self._vehicle = vehicle
        self._first: list[Sample] | None = [] if vehicle.linkage is not None else None
        self.samples = 0
        self.incomplete = 0

    def step(self, sample: Sample) -> None:
        """Take a sample."""
        self.samples += 1
        self.incomplete += not all(sample.present)
        for odometer in self._odometers.values():
            odometer.step(sample)
        self._joints = self._link.read(sample.counts)
        if self._tracker is not None:
            self._tracker.step(sample)
        elif self._first is not None and all(sample.present):
            self._first.append(sample)
            if len(self._first) == LOADING:
                samples, self._first = self._first, None
                threading.Thread(
                    target=self._load, args=(samples,), name="loading the tracker", daemon=True
                ).start()

    def _load(self, samples: list[Sample]) -> None:
        from ipec.tracker import Tracker

        trial = Tracker(self._vehicle)
        for sample in samples:
            trial.step(sample)
        pose = self._odometers["a"].pose
        self._tracker = Tracker(self._vehicle, pose)
        gc.freeze()  # what is loaded by now stays; to look through it takes a tenth of a second

    def look(self) -> dict[str, Any]:
        """Return what is known, as the stream's `state` event holds it."""
        tracker = self._tracker
        row = tracker.row() if tracker is not None and tracker.started else None
        return {
            "plain": _pose(self._odometers["a"].pose),
            "ipec": None if row is None else _pose(row.ipec),
            "filter": None if row is None else _pose(row.filtered),
            "sigma": None if row is None else _pose(row.sigma),
            "follower": _follower(None if row is None else row.follower, self._odometers),
            "joints": _joints(self._joints),
            "corrections": None if row is None else dict(zip("ab", row.corrections.tolist(), strict=True)),
            "lost": None if row is None else dict(zip(WHEELS, row.lost.tolist(), strict=True)),
        }


def _joints(read: tuple[float, float, float] | None) -> dict[str, float] | None:
    if read is None:
        return None
    return {"a": float(wrap(read[0])), "b": float(wrap(read[1])), "length": read[2]}


def _pose(pose: Sequence[float] | np.ndarray[Any, Any]) -> dict[str, float] | None:
    if not np.isfinite(pose).all():
        return None
    x, y, theta = (round(float(value), 6) for value in pose)
    return {"x": x, "y": y, "theta": theta}


def _follower(
    filtered: np.ndarray[Any, Any] | None, odometers: dict[Any, Odometer]
) -> dict[str, float] | None:
    if filtered is not None:
        return _pose(filtered)
    return _pose(odometers["b"].pose) if "b" in odometers else None
