"""Where the robot is: plain odometry from the start, IPEC and the filter once they are loaded."""

from __future__ import annotations

import gc
import threading
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimate.motion.reading import LinkReader
from omnimate.vehicle.odometry import Odometer
from omnimate.vehicle.parameters import WHEELS
from omnimate.vehicle.se2 import wrap

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.ipec.tracker import Tracker
    from omnimate.vehicle.arcs import PoseTuple
    from omnimate.vehicle.parameters import VehicleParameters
    from omnimate.vehicle.sample import Sample

LOADING_SAMPLES = 3  # after which everything that a tracker calls has been loaded


class Localization:
    """Localizes a robot from its samples; only one thread may call it.

    The tracker's compiled code is loaded in another thread, which on a new machine takes half a minute.
    Until then there is plain odometry, and no sample is delayed. A process that ends meanwhile waits for it.

    Attributes:
        tracker: The tracker; None until it is loaded, and for a robot with a single truck.
    """

    def __init__(self, vehicle: VehicleParameters) -> None:
        self._vehicle = vehicle
        self._odometers = {truck: Odometer(vehicle, truck) for truck in vehicle.trucks}
        self._link = LinkReader(vehicle)
        self._counts: Sequence[int] | None = None
        self.tracker: Tracker | None = None
        self._first_samples: list[Sample] | None = [] if vehicle.linkage is not None else None

    def locate(self, sample: Sample) -> PoseTuple:
        """Return the pose of truck a by plain odometry after the next sample."""
        for odometer in self._odometers.values():
            odometer.step(sample)
        return self._odometers["a"].pose

    def step(self, sample: Sample) -> None:
        """Update IPEC and the filter with the sample that was located last; that may take a few ms."""
        self._counts = sample.counts
        if self.tracker is not None:
            self.tracker.step(sample)
        elif self._first_samples is not None and all(sample.present):
            self._first_samples.append(sample)
            if len(self._first_samples) == LOADING_SAMPLES:
                samples, self._first_samples = self._first_samples, None
                # no daemon: the compiler crashes where the interpreter is taken down while it works
                threading.Thread(
                    target=self._load_tracker, args=(samples,), name="loading the tracker", daemon=False
                ).start()

    def _load_tracker(self, samples: list[Sample]) -> None:
        from omnimate.ipec.tracker import Tracker

        trial = Tracker(self._vehicle)
        for sample in samples:
            trial.step(sample)
        self.tracker = Tracker(self._vehicle, self._odometers["a"])
        gc.freeze()  # a garbage collection of everything that was loaded would take a tenth of a second

    def as_event(self) -> dict[str, Any]:
        """Return the part of the stream's `state` event that says where the robot is."""
        event: dict[str, Any] = {
            "plain": _pose(self._odometers["a"].pose),
            "follower": _pose(self._odometers["b"].pose) if "b" in self._odometers else None,
            "joints": self._joints(),
            **dict.fromkeys(("ipec", "filter", "sigma", "corrections", "lost")),
        }
        if self.tracker is not None and self.tracker.started:
            row = self.tracker.row()
            event |= {
                "ipec": _pose(row.ipec),
                "filter": _pose(row.filtered),
                "sigma": _pose(row.sigma),
                "follower": _pose(row.follower),
                "corrections": dict(zip("ab", row.corrections.tolist(), strict=True)),
                "lost": dict(zip(WHEELS, row.lost.tolist(), strict=True)),
            }
        return event

    def _joints(self) -> dict[str, float] | None:
        """Return the latest readings of the linkage; None before the first, and for a single truck."""
        read = None if self._counts is None else self._link.read(self._counts)
        if read is None:
            return None
        return {"a": float(wrap(read[0])), "b": float(wrap(read[1])), "length": read[2]}


def _pose(pose: Sequence[float] | np.ndarray[Any, Any]) -> dict[str, float] | None:
    """Return a pose, or None where a part of it is not known."""
    if not np.isfinite(pose).all():
        return None
    x, y, theta = (round(float(value), 6) for value in pose)
    return {"x": x, "y": y, "theta": theta}
