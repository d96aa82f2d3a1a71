"""The simulated vehicle on a bus: its plant moves one step for each SYNC, and its devices answer."""

from __future__ import annotations

import math
import time
from collections import deque
from typing import TYPE_CHECKING, Literal

import can

from omnimate.vcan_sim.faults import FaultSchedule
from omnimate.vcan_sim.nodes.build import build_devices
from omnimate.vcan_sim.nodes.device import SYNC_ID
from omnimate.vcan_sim.nodes.drive import DriveDevice
from omnimate.vcan_sim.nodes.encoder import Latch
from omnimate.vcan_sim.nodes.router import Router

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from omnimate.vcan_sim.faults import DeviceFault
    from omnimate.vcan_sim.nodes.device import Device
    from omnimate.vcan_sim.plant import Plant
    from omnimate.vehicle.parameters import VehicleParameters

_TOLERANCE = 1e-9  # [s] of comparisons; device times are sums of periods, with rounding errors


class SimulatedVehicle:
    """All devices of a vehicle on one bus.

    With the clock "sync" the devices' time, for heartbeats, event timers and faults, is the number of SYNCs
    times the SYNC period, and does not depend on the machine. With the clock "wall" it is the monotonic time
    since the start, and timers run without SYNC, too. With both, the plant advances by one SYNC period for
    each SYNC. The drives (6083h, 6084h) limit the acceleration to twice the vehicle's limit.
    """

    def __init__(
        self,
        vehicle: VehicleParameters,
        plant: Plant,
        bus: can.BusABC,
        clock: Literal["sync", "wall"] = "sync",
        faults: Iterable[DeviceFault] = (),
        wheel_speeds: Callable[[], Sequence[float]] | None = None,
    ) -> None:
        """Build and boot the devices; their boot-up messages are on the bus when this returns.

        Args:
            vehicle: Nominal parameters of the vehicle whose devices are on the bus.
            plant: Mechanics that are moved by one step for each SYNC.
            bus: Bus for the devices alone; the caller shuts it down.
            clock: Clock of the devices, "sync" or "wall".
            faults: Faults, which begin at their times on the devices' clock.
            wheel_speeds: Returns the wheel speeds [rad/s] at each SYNC, in place of the drives.

        Raises:
            SimulationError: The vehicle's parameters cannot be realised by the simulated devices.
            FaultError: The vehicle has no such node.
        """
        self.vehicle = vehicle
        self.plant = plant
        self.syncs = 0
        self._bus = bus
        self._period = vehicle.bus.sync_period
        self._wall = clock == "wall"
        self._started = time.monotonic()
        self._time = 0.0
        self._wheel_speeds = wheel_speeds
        self._latch = Latch(plant.raw_counts(), self._period)
        self._devices = build_devices(vehicle, self._latch, self._send)
        self.devices: dict[int, Device] = {device.node: device for device in self._devices}
        self._router = Router(self._devices)
        self._drives = self._drives_by_wheel()
        self._schedule = FaultSchedule(self.devices, faults)
        self._injected: deque[DeviceFault] = deque()
        for device in self._devices:
            device.boot(0.0)

    def _drives_by_wheel(self) -> tuple[DriveDevice | None, ...]:
        nodes = {drive.wheel: self.devices[drive.node] for drive in self.vehicle.drives}
        drives = (nodes.get(wheel) for wheel in self.vehicle.wheels)
        return tuple(drive if isinstance(drive, DriveDevice) else None for drive in drives)

    @property
    def time(self) -> float:
        """The devices' clock [s]."""
        return time.monotonic() - self._started if self._wall else self._time

    def wait(self) -> float | None:
        """Return the time until the next timer ends [s]; None if there is none, or with the clock "sync"."""
        if not self._wall:
            return None
        due = min(self._schedule.due, min((device.due for device in self._devices), default=math.inf))
        return max(0.0, due - self.time) if due < math.inf else None

    # Running

    def poll(self) -> int:
        """Process all waiting frames and due timers; return the number of frames."""
        frames = 0
        while (message := self._bus.recv(0.0)) is not None:
            self.receive(message)
            frames += 1
        if self._wall or self._injected:
            now = self.time
            self._run_faults(now)
            self._run_device_timers(now)
        return frames

    def inject(self, fault: DeviceFault) -> None:
        """Begin a fault now, from any thread; raises FaultError if the vehicle has no such node."""
        self._schedule.check(fault)
        self._injected.append(fault)

    # Frames

    def receive(self, message: can.Message) -> None:
        """Receive one frame of the bus; frames other than CANopen's base format are ignored."""
        if message.is_extended_id or message.is_error_frame or message.is_fd:
            return
        if message.arbitration_id == SYNC_ID and not message.is_remote_frame:
            self._on_sync(message)
        else:
            self._router.receive(message, self.time)

    def _on_sync(self, message: can.Message) -> None:
        """Advance the plant by one period, latch all counts, and run the devices' answers and timers."""
        self.syncs += 1
        self._time = self.syncs * self._period
        now = self.time
        self._run_faults(now)
        self.plant.step(self._speeds(), self._period)
        self._latch.take(self.plant.raw_counts())
        self._router.receive(message, now)
        self._run_device_timers(now)

    def _speeds(self) -> Sequence[float]:
        if self._wheel_speeds is not None:
            return self._wheel_speeds()
        period = self._period
        return [drive.advance(period) if drive is not None else 0.0 for drive in self._drives]

    def _send(self, cob_id: int, data: bytes) -> None:
        self._bus.send(can.Message(arbitration_id=cob_id, data=data, is_extended_id=False, check=False))

    # Time

    def _run_device_timers(self, now: float) -> None:
        now += _TOLERANCE
        for device in self._devices:
            if device.due <= now:
                device.run_timers(now)

    def _run_faults(self, now: float) -> None:
        if not self._injected and now < self._schedule.due - _TOLERANCE:
            return
        while self._injected:
            self._schedule.begin(self._injected.popleft(), now)
        self._schedule.run(now + _TOLERANCE)
        self._router.invalidate_routes()
