"""A simulated vehicle on a bus for other processes: hub and vehicle in one event loop."""

from __future__ import annotations

import asyncio
import signal
from typing import TYPE_CHECKING

from omnimate.vcan_sim.errors import FaultError
from omnimate.vcan_sim.hub import Hub
from omnimate.vcan_sim.simulated_vehicle import SimulatedVehicle

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from omnimate.vcan_sim.faults import DeviceFault
    from omnimate.vcan_sim.plant import Plant
    from omnimate.vehicle.parameters import VehicleParameters

    WheelSpeeds = Callable[[], Sequence[float]]


class BusServer:
    """Serves one simulated vehicle's bus, the `hub`."""

    def __init__(
        self,
        vehicle: VehicleParameters,
        plant: Plant,
        faults: Iterable[DeviceFault],
        wheel_speeds: WheelSpeeds | None,
    ) -> None:
        plant.step((0.0,) * len(vehicle.wheels), vehicle.bus.sync_period)  # compiled code is loaded now
        self.hub = Hub()
        self._timer: asyncio.TimerHandle | None = None
        self._bus = self.hub.attach(self._poll)
        try:
            self.simulated = SimulatedVehicle(vehicle, plant, self._bus, "wall", faults, wheel_speeds)
        except FaultError:
            self._bus.shutdown()
            raise

    async def run(self, host: str, port: int, stop: asyncio.Event, on_ready: Callable[[int], None]) -> None:
        """Serve until `stop` is set; `on_ready` gets the port once clients may connect; raises HubError."""
        try:
            on_ready(await self.hub.start(host, port))
            self._poll()
            await stop.wait()
        finally:
            if self._timer is not None:
                self._timer.cancel()
            await self.hub.stop()
            self._bus.shutdown()

    def _poll(self) -> None:
        """Process waiting frames and due timers, and schedule the next call."""
        self.simulated.poll()
        if self._timer is not None:
            self._timer.cancel()
        wait = self.simulated.wait()
        loop = asyncio.get_running_loop()
        self._timer = loop.call_later(wait, self._poll) if wait is not None else None


def serve(
    vehicle: VehicleParameters,
    plant: Plant,
    host: str = "127.0.0.1",
    port: int = 29536,
    faults: Iterable[DeviceFault] = (),
    on_ready: Callable[[int], None] = lambda _port: None,
    wheel_speeds: WheelSpeeds | None = None,
) -> None:
    """Serve a simulated vehicle's bus until SIGINT or SIGTERM; to be called in the main thread.

    Raises HubError where the address cannot be listened on, and the errors of `SimulatedVehicle`.
    """
    server = BusServer(vehicle, plant, faults, wheel_speeds)

    async def until_signal() -> None:
        stop = asyncio.Event()
        for number in (signal.SIGINT, signal.SIGTERM):
            asyncio.get_running_loop().add_signal_handler(number, stop.set)
        await server.run(host, port, stop, on_ready)

    asyncio.run(until_signal())
