"""The schedule of device faults: their beginnings and ends on the devices' clock."""

from __future__ import annotations

import heapq
import math
from itertools import count
from typing import TYPE_CHECKING

from omnimate.vcan_sim.errors import FaultError

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from omnimate.vcan_sim.faults import DeviceFault
    from omnimate.vcan_sim.nodes.device import Device


class FaultSchedule:
    """Begins and ends faults as the clock passes their times.

    Attributes:
        due: Time at which the next fault begins or ends [s].
    """

    def __init__(self, devices: Mapping[int, Device], faults: Iterable[DeviceFault]) -> None:
        self._devices = devices
        self._order = count()  # order of the events of one time
        self._events: list[tuple[float, int, bool, DeviceFault]] = []
        self.due = math.inf
        for fault in faults:
            self.check(fault)
            self._add(fault.at, fault, begins=True)

    def check(self, fault: DeviceFault) -> None:
        """Raise FaultError if the fault's node is not on the bus."""
        if fault.node not in self._devices:
            nodes = ", ".join(str(node) for node in self._devices)
            raise FaultError(
                f"{fault.name}:node={fault.node}",
                f"no node {fault.node} on this bus; expected one of {nodes}",
            )

    def begin(self, fault: DeviceFault, now: float) -> None:
        """Begin a fault now [s], without regard to its `at`, and schedule its end."""
        fault.begin(self._devices[fault.node], now)
        if fault.duration < math.inf:
            self._add(now + fault.duration, fault, begins=False)

    def run(self, now: float) -> None:
        """Begin and end the faults whose times have passed [s]."""
        while self._events and self._events[0][0] <= now:
            _, _, begins, fault = heapq.heappop(self._events)
            if begins:
                self.begin(fault, now)
            else:
                fault.end(self._devices[fault.node], now)
        self.due = self._events[0][0] if self._events else math.inf

    def _add(self, time: float, fault: DeviceFault, *, begins: bool) -> None:
        heapq.heappush(self._events, (time, next(self._order), begins, fault))
        self.due = self._events[0][0]
