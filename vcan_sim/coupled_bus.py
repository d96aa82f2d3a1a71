"""A bus in one thread: the simulated vehicle answers within the master's `send`.

python-can's virtual bus needs a thread for the vehicle, and two context switches per SYNC, which take more
time than the simulation. Here there are neither threads nor copies of frames, and each run gives the same
frames.
"""

from __future__ import annotations

import time
from collections import deque
from typing import TYPE_CHECKING, Literal

import can

from omnimate.vcan_sim.simulated_vehicle import SimulatedVehicle

if TYPE_CHECKING:
    from collections.abc import Iterable

    from omnimate.vcan_sim.faults import DeviceFault
    from omnimate.vcan_sim.plant import Plant
    from omnimate.vehicle.parameters import VehicleParameters


class _VehicleEnd(can.BusABC):
    """The vehicle's end of the bus: a queue of the frames that it sends."""

    def __init__(self) -> None:
        self.sent: deque[can.Message] = deque()
        super().__init__(channel="coupled")

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Append a frame to the queue, with a time stamp."""
        del timeout
        msg.timestamp = time.time()
        self.sent.append(msg)

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """Return None: the vehicle gets its frames by `receive`."""
        del timeout
        return None


class CoupledBus(can.BusABC):
    """The master's end of the bus of a `simulated` vehicle, for one thread.

    With the clock "sync" the vehicle acts only within `send`. With the clock "wall", `simulated.poll()` must
    also be called when a timer ends (`simulated.wait`).
    """

    def __init__(
        self,
        vehicle: VehicleParameters,
        plant: Plant,
        faults: Iterable[DeviceFault] = (),
        clock: Literal["sync", "wall"] = "sync",
    ) -> None:
        """Build the vehicle, whose boot-up messages wait then; errors as of `SimulatedVehicle`."""
        self._end = _VehicleEnd()
        self.simulated = SimulatedVehicle(vehicle, plant, self._end, clock, faults)
        self.channel_info = f"simulated vehicle {vehicle.name}"
        super().__init__(channel="coupled")

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Send a frame; the vehicle's answers can be received when this returns."""
        del timeout
        self.simulated.receive(msg)

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """Return the next frame, or None after `timeout` [s]; raises CanOperationError without one."""
        if self._end.sent:
            return self._end.sent.popleft()
        if timeout is None:
            raise can.CanOperationError("no frame can arrive before one is sent; receive with a timeout")
        if timeout > 0.0:
            time.sleep(timeout)
        return None

    def shutdown(self) -> None:
        """Close both ends."""
        self._end.shutdown()
        super().shutdown()
