"""The samples of the robot: counted, localized, and described as events."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

from omnimate.service.robot.localization import Localization

if TYPE_CHECKING:
    from omnimate.driver.robot.driver import Driver
    from omnimate.driver.robot.report import DriverReport
    from omnimate.ipec.tracker import Learned
    from omnimate.service.robot.reservation import Reservation
    from omnimate.vehicle.arcs import PoseTuple
    from omnimate.vehicle.parameters import VehicleParameters
    from omnimate.vehicle.sample import Sample

STATE_PERIOD = 0.1  # [s] between two `state` events
NODES_PERIOD = 1.0  # [s] between two `nodes` events


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
