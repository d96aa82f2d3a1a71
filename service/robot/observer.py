"""The samples of the robot: counted, localized by odometry, IPEC and the filter, and described as events."""

from __future__ import annotations

import gc
import threading
import time
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimate.motion.drive import LinkReader
from omnimate.vehicle.odometry import Odometer
from omnimate.vehicle.parameters import WHEELS
from omnimate.vehicle.se2 import wrap

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.driver.robot.driver import Driver
    from omnimate.driver.robot.report import DriverReport
    from omnimate.ipec.tracker import Learned, Tracker
    from omnimate.service.robot.reservation import Reservation
    from omnimate.vehicle.arcs import PoseTuple
    from omnimate.vehicle.parameters import VehicleParameters
    from omnimate.vehicle.sample import Sample

STATE_PERIOD = 0.1  # [s] between two `state` events
NODES_PERIOD = 1.0  # [s] between two `nodes` events
LOADING_SAMPLES = 3  # after which everything that a tracker calls has been loaded


class Localization:
    """Localizes a robot from its samples; only one thread may call it.

    The tracker's compiled code is loaded in another thread, which on a new machine takes half a minute.
    Until then there is plain odometry, and no sample is delayed. A process that ends meanwhile waits for it.
    """

    def __init__(self, vehicle: VehicleParameters) -> None:
        self._vehicle = vehicle
        self._odometers = {truck: Odometer(vehicle, truck) for truck in vehicle.trucks}
        self._link = LinkReader(vehicle)
        self._counts: Sequence[int] | None = None
        self.tracker: Tracker | None = None  # stays None for a robot with a single truck
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


class Observer:
    """Takes every sample of the robot's thread; its attributes are those of `RobotStatus`."""

    def __init__(self, mode: str, reservation: Reservation) -> None:
        self.state: dict[str, Any] = {}
        self.report: DriverReport | None = None
        self.samples = 0
        self.incomplete = 0
        self._mode, self._reservation = mode, reservation
        self._localization: Localization | None = None
        self._state_sent = self._nodes_sent = 0.0

    def begin(self, vehicle: VehicleParameters) -> None:
        """Localize the robot from its first sample on, with these parameters."""
        self._localization = Localization(vehicle)

    def learned(self) -> Learned | None:
        """Return what the tracker has learned, of which vehicle; None where it does not follow the robot."""
        tracker = None if self._localization is None else self._localization.tracker
        return tracker.learned if tracker is not None and tracker.started else None

    def read(self, driver: Driver) -> None:
        """Read the next sample and observe it."""
        sample = driver.cycle()
        self.locate(sample)
        self.observe(sample, driver)

    def locate(self, sample: Sample) -> PoseTuple:
        """Return the pose of truck a by plain odometry after the next sample."""
        assert self._localization is not None  # begin() was called
        return self._localization.locate(sample)

    def observe(self, sample: Sample, driver: Driver) -> None:
        """Take the sample that was located last; describe the robot and its nodes when it is time."""
        assert self._localization is not None
        self.samples += 1
        self.incomplete += not all(sample.present)
        self._localization.step(sample)
        now = time.monotonic()
        if now - self._state_sent >= STATE_PERIOD:
            self._state_sent = now
            self.state = self._state_event(sample.time, driver.drives.speeds)
        if now - self._nodes_sent >= NODES_PERIOD:
            self._nodes_sent = now
            self.report = driver.report()

    def note_problem(self) -> None:
        """Note that the robot cannot be read, and why."""
        self.state = self._state_event(None)

    def _state_event(self, at: float | None, wheels: tuple[float, ...] = ()) -> dict[str, Any]:
        poses = {} if self._localization is None else self._localization.as_event()
        held = self._reservation
        return state_event(self._mode, held.problem, at, held.session, held.lap, wheels) | poses


def state_event(
    mode: str,
    problem: str | None,
    at: float | None = None,
    session: str | None = None,
    lap: str | None = None,
    wheels: tuple[float, ...] = (),
) -> dict[str, Any]:
    """Return the stream's `state` event, without the robot's poses."""
    return {
        "time": at, "mode": mode, "problem": problem, "driving": session, "lap": lap, "wheels": list(wheels),
    }  # fmt: skip


def nodes_event(report: DriverReport) -> dict[str, Any]:
    """Return the stream's `nodes` event."""
    return {
        "nodes": [
            {
                "node": node.node, "names": list(node.names), "state": node.state,
                "received": node.received, "missing": node.missing, "restarts": node.restarts,
                "emergencies": node.emergencies, "ok": node.is_well,
            }
            for node in report.nodes
        ]
    }  # fmt: skip
