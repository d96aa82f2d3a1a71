"""What must hold whatever fails: of the pose, of the wheels, of the reports, and of the recording.

The laws are looser than their words:

- A step of the pose over lost samples, or near a fault of the truck or the bus, may be wrong by
  `2 + MAX_RATIO` times the travel meanwhile. Only steps without any of this are held to `COUNT_ERROR`.
- A report is explained by any fault of its node, its truck or the bus in the `AFTERMATH` before it, whatever
  the two say. One of the bus is explained by a fault of any node, one of the recording by a full disk only.
- A report is required only of a fault that begins while all is well, lasts long enough, and meets no restart
  and no other fault of its node or the bus.
- A recording is compared where a channel is present in both, and in the samples before and after, from the
  first such sample. From the first full disk on only the times of its samples are. Within `ACKNOWLEDGED` of
  a full disk, and before a power cut, nothing is required.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence

from omnimate.driver.robot.events import Event
from omnimate.vehicle.arcs import PoseTuple
from omnimate.vehicle.bridging import MAX_RATIO
from omnimate.vehicle.odometry import Odometer, wheels_of
from omnimate.vehicle.parameters import TruckName, VehicleParameters
from omnimate.vehicle.sample import Sample
from studies.faults.script import INSTANT, Fault
from studies.faults.world import START, World

COUNT_ERROR = 3e-5  # [m] of a step of the pose: two counts of the encoders
ACKNOWLEDGED = 0.55  # [s] after which a frame is on the disk: the writer's interval, and a cycle
SETTLED = 0.2  # [s] after a fault, in which its last frames have come
AFTERMATH = 12.0  # [s] after a fault, in which its node may still be restarted and configured again
# What must be reported of a fault of an encoder and of a drive, and how long it must last for it [s]. Other
# faults are counted in the report, or are seen only where a wheel turns meanwhile.
REPORTS: dict[str, tuple[str, str, float]] = {
    "silence": ("no valid answer", "heartbeat lost|no answer for its status word", 0.15),
    "reboot": ("restarted", "restarted|heartbeat lost", 0.0),
    "length": ("no valid answer", "", 0.1),
    "emcy": ("EMCY", "EMCY", 0.0),
    "babbling": ("babbles", "babbles", 1.2),
    "nmt stop": ("no valid answer|lost its configuration", "lost its configuration", 0.0),
    "nmt pre-operational": ("no valid answer|lost its configuration", "lost its configuration", 0.0),
    "nmt reset": ("restarted", "restarted", 0.0),
    "nmt communication": ("restarted", "restarted", 0.0),
    "trip": ("", "left operation enabled", 0.0),
    "twin": ("answers each SYNC twice", "", 1.6),
    "adapter": ("interface failed", "", 0.0),
    "power": ("interface failed", "", 0.0),
    "sync": ("another device produces SYNC", "", 0.1),
    "disk full": ("No space left", "", 1.2),
}


class PoseLaw:
    """The pose of one truck never jumps by more than the travel that the lost samples explain.

    Each step of dead reckoning is compared with that of the true pose. A step over samples that were lost, or
    that a fault made wrong, may be wrong by twice their travel, and where a counter was reset by what
    `bridge` may make of it.
    """

    def __init__(self, world: World, truck: TruckName) -> None:
        vehicle = world.vehicle
        self.worst = 0.0  # largest error of a step in which no sample was lost [m]
        self._world, self._truck = world, truck
        self._columns = [vehicle.channels.index(wheel) for wheel in wheels_of(truck)]
        self._nodes = {vehicle.encoder(wheel).node for wheel in wheels_of(truck)}
        self._longest = 1.5 * vehicle.bus.sync_period
        self._half = vehicle.trucks[truck].wheelbase / 2.0
        self._last_true = self._true = world.poses[truck]
        self._doubt, self._is_doubted, self._time = 0.0, True, -math.inf
        self.begin()

    def begin(self) -> None:
        """Begin with another driver; what an encoder that is frozen meanwhile has lost is still in doubt."""
        # dead reckoning of the truck from the driver's samples
        self._odometer = Odometer(self._world.vehicle, self._truck)
        self._pose: PoseTuple | None = None

    def check(self, sample: Sample, faults: Sequence[Fault]) -> str | None:
        """Return how the law is broken by a sample in a session with faults; None where it holds."""
        true = self._world.poses[self._truck]
        travel = self._size(self._last_true, true)
        self._last_true = true
        is_read = all(sample.present[column] for column in self._columns)
        is_next = sample.time - self._time < self._longest
        self._time = sample.time
        is_doubtful = not (is_read and is_next) or any(
            fault.concerns(*self._nodes)
            and START + fault.at <= self._world.now <= START + fault.at + fault.duration + SETTLED
            for fault in faults
        )
        was_doubted, self._is_doubted = self._is_doubted, is_doubtful
        if is_doubtful or was_doubted:
            self._doubt += travel
        if not is_read:
            return None
        before, self._pose = self._pose, self._odometer.step(sample)
        true_step, self._true = _between(self._true, true), true
        if before is None:
            return None
        step = _between(before, self._pose)
        error = math.dist(step[:2], true_step[:2]) + self._half * abs(step[2] - true_step[2])
        allowed = COUNT_ERROR + (2.0 + MAX_RATIO) * self._doubt
        if not self._doubt:
            self.worst = max(self.worst, error)
        if not is_doubtful:
            self._doubt = 0.0
        if error <= allowed:
            return None
        explained = f"lost samples explain {1e3 * allowed:.2f} mm"
        return f"pose of truck {self._truck} jumps by {1e3 * error:.2f} mm; {explained}"

    def _size(self, first: PoseTuple, second: PoseTuple) -> float:
        """Return a bound of the travel of either wheel between two poses that are near [m]."""
        step = _between(first, second)
        return math.hypot(*step[:2]) + self._half * abs(step[2])


def _between(first: PoseTuple, second: PoseTuple) -> PoseTuple:
    """Return `second` as seen from `first`, as `between` does, which takes ten times as long for one pose."""
    x, y, angle = second[0] - first[0], second[1] - first[1], first[2]
    cos, sin = math.cos(angle), math.sin(angle)
    return cos * x + sin * y, cos * y - sin * x, second[2] - angle


def is_explained(event: Event, faults: Sequence[Fault], vehicle: VehicleParameters) -> bool:
    """Return whether a fault is there that an event may come from: of its node, its truck, or the bus.

    The wheels of one truck are compared with each other and with their drives, so that the fault of one node
    is seen at another.
    """
    related = _truck_of(event.node, vehicle) if event.node is not None else None
    is_of_disk = event.what.startswith("recording:")
    return any(
        is_of_disk == (fault.kind == "disk full")
        and (is_of_disk or fault.concerns() or related in {None, _truck_of(fault.node, vehicle)})
        and START + fault.at - 0.001 <= event.last <= START + fault.at + fault.duration + AFTERMATH
        for fault in faults
    )


def _truck_of(node: int, vehicle: VehicleParameters) -> str:
    """Return the truck of a node's wheel; another node is alone."""
    wheels = {encoder.node: encoder.channel for encoder in vehicle.encoders}
    wheels |= {drive.node: drive.wheel for drive in vehicle.drives}
    truck, _, wheel = wheels[node].partition(".")
    return truck if wheel else str(node)


def expectation(fault: Fault, faults: Sequence[Fault], *, is_drive: bool) -> Callable[[Event], bool] | None:
    """Return what an event must be that reports a fault; None where none is expected.

    Faults that meet others of the same node or of the bus may hide behind these.
    """
    encoder, drive, shortest = REPORTS.get(fault.kind, ("", "", 0.0))
    words = drive if is_drive else encoder
    end = fault.at + fault.duration
    others = [
        other
        for other in faults
        if other is not fault
        and (other.concerns(fault.node) or fault.node == 0)
        and other.at - 0.5 < end + SETTLED
        and other.at + other.duration + AFTERMATH > fault.at
    ]
    if not words or others or (fault.kind not in INSTANT and fault.duration < shortest):
        return None
    pattern, node = re.compile(words), fault.node or None
    return lambda event: (
        (node is None or event.node == node or event.node is None)
        and event.last >= START + fault.at
        and bool(pattern.search(event.what))
    )
