"""The simulated vehicle on a bus: its plant moves one step for each SYNC, and its devices answer."""

from __future__ import annotations

import logging
import math
import threading
import time
from collections import deque
from typing import TYPE_CHECKING, Literal, Protocol

import can

from vcan_sim.errors import SimulationError
from vcan_sim.fault_schedule import FaultSchedule
from vcan_sim.nodes.build import build_devices
from vcan_sim.nodes.device import SYNC_ID
from vcan_sim.nodes.drive import DriveDevice
from vcan_sim.nodes.sensor import Latch

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from vcan_sim.faults import Fault
    from vcan_sim.nodes.device import Device
    from vcan_sim.nodes.pdo import Rpdo
    from vehicle.parameters import VehicleParameters

_log = logging.getLogger(__name__)

_TOLERANCE = 1e-9  # [s]; device times are sums of periods
_LONGEST_WAIT = 0.05  # [s]; after which the thread looks for `stop` and for faults injected


class Plant(Protocol):
    """What the devices move and measure."""

    def step(self, wheel_speeds: Sequence[float], dt: float) -> None:
        """Turn the wheels, in the order of `vehicle.wheels` [rad/s], for `dt` [s]."""

    def raw_counts(self) -> Sequence[int]:
        """Return the counters, in the order of `vehicle.channels`, as wide and signed as these say."""
        ...


class SimulatedVehicle:
    """All devices of a vehicle on one bus.

    With clock "sync" the devices' time is the number of SYNCs times the SYNC period: heartbeats, event
    timers and faults run on it, and nothing depends on the machine. With clock "wall" it is monotonic
    time since the start, and timers run without SYNC too. The plant moves by one SYNC period per SYNC in
    both. Acceleration is limited by the drives (6083h, 6084h), at twice what the vehicle's limits say.

    Attributes:
        vehicle: its nominal parameters: node ids, COB-IDs, resolutions.
        plant: what moves.
        devices: by node id.
        syncs: SYNCs seen.
        failure: what ended the thread, where something did.
    """

    def __init__(
        self,
        vehicle: VehicleParameters,
        plant: Plant,
        bus: can.BusABC,
        clock: Literal["sync", "wall"] = "sync",
        faults: Iterable[Fault] = (),
        wheel_speeds: Callable[[SimulatedVehicle], Sequence[float]] | None = None,
    ) -> None:
        """Build the devices and let them boot: their boot-up messages are on the bus when this returns.

        Args:
            vehicle: what hangs on the bus.
            plant: moved by one step per SYNC.
            bus: of its own; the caller shuts it down.
            clock: "sync" or "wall".
            faults: by their times on the devices' clock.
            wheel_speeds: asked at each SYNC in the drives' place [rad/s].

        Raises:
            SimulationError: no such devices exist.
            FaultError: a fault is of a node that the vehicle has not.
        """
        self.vehicle = vehicle
        self.plant = plant
        self.syncs = 0
        self.failure: Exception | None = None
        self._bus = bus
        self._period = vehicle.bus.sync_period
        self._wall = clock == "wall"
        self._started = time.monotonic()
        self._time = 0.0
        self._wheel_speeds = wheel_speeds
        self._latch = Latch(plant.raw_counts(), self._period)
        self._devices = build_devices(vehicle, self._latch, self._send)
        self.devices: dict[int, Device] = {device.node: device for device in self._devices}
        self._drives = self._drives_by_wheel()
        self._routes: dict[int, list[tuple[Device, Rpdo]]] | None = None
        self._schedule = FaultSchedule(self.devices, faults)
        self._injected: deque[Fault] = deque()
        self._thread: threading.Thread | None = None
        self._stopping = threading.Event()
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
        """Return how long nothing is due without a frame [s]; None where only a SYNC makes time pass."""
        if not self._wall:
            return None
        due = min(self._schedule.due, min((device.due for device in self._devices), default=math.inf))
        return max(0.0, due - self.time) if due < math.inf else None

    # Running

    def start(self) -> None:
        """Answer the bus in a thread of its own, until `stop`."""
        if self._thread is not None:
            raise SimulationError("the simulated vehicle has been started already; stop it first")
        self._stopping.clear()
        self._thread = threading.Thread(target=self._run, name="simulated vehicle", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End the thread; without one nothing happens."""
        if self._thread is not None:
            self._stopping.set()
            self._thread.join()
            self._thread = None

    def _run(self) -> None:
        try:
            while not self._stopping.is_set():
                wait = self.wait()
                message = self._bus.recv(_LONGEST_WAIT if wait is None else min(wait, _LONGEST_WAIT))
                if message is not None:
                    self.receive(message)
                if self._wall or self._injected:
                    self._run_timers(self.time)
        except (can.CanError, OSError) as error:
            self.failure = error
            _log.exception("the simulated vehicle has lost its bus")

    def poll(self) -> int:
        """Answer all frames that wait on the bus and do what is due; return how many frames there were."""
        frames = 0
        while (message := self._bus.recv(0.0)) is not None:
            self.receive(message)
            frames += 1
        if self._wall or self._injected:
            self._run_timers(self.time)
        return frames

    def inject(self, fault: Fault) -> None:
        """Let a fault begin now, for its duration; may be called from any thread.

        Raises:
            FaultError: the vehicle has no such node.
        """
        self._schedule.check(fault)
        self._injected.append(fault)

    # Frames

    def receive(self, message: can.Message) -> None:
        """Take one frame from the bus; what is not of CANopen's base format is ignored."""
        if message.is_extended_id or message.is_remote_frame or message.is_error_frame or message.is_fd:
            return
        can_id = message.arbitration_id
        if can_id == SYNC_ID:
            self._on_sync()
        elif can_id == 0x000:
            self._on_nmt(message.data)
        elif 0x600 < can_id <= 0x67F:
            self._on_sdo(can_id - 0x600, message.data)
        elif 0x700 < can_id <= 0x77F:
            for device in self._devices:
                device.on_heartbeat(can_id - 0x700, self.time)
        else:
            self._on_rpdo(can_id, message.data)

    def _on_sync(self) -> None:
        """Move the plant by one period, latch all counters, let the devices answer, run their timers."""
        self.syncs += 1
        self._time = self.syncs * self._period
        now = self.time
        self._run_faults(now)
        self.plant.step(self._speeds(), self._period)
        self._latch.take(self.plant.raw_counts())
        for device in self._devices:
            device.on_sync(now)
        self._run_device_timers(now)

    def _speeds(self) -> Sequence[float]:
        if self._wheel_speeds is not None:
            return self._wheel_speeds(self)
        period = self._period
        return [drive.advance(period) if drive is not None else 0.0 for drive in self._drives]

    def _on_nmt(self, data: bytearray) -> None:
        if len(data) == 2:
            for device in self._devices:
                if data[1] in {0, device.node}:
                    device.on_nmt(data[0], self.time)
        self._routes = None

    def _on_sdo(self, node: int, data: bytearray) -> None:
        device = self.devices.get(node)
        if device is not None:
            device.on_sdo(bytes(data), self.time)
            self._routes = None

    def _on_rpdo(self, can_id: int, data: bytearray) -> None:
        if self._routes is None:
            self._routes = self._find_routes()
        for device, rpdo in self._routes.get(can_id, ()):
            device.on_rpdo(rpdo, bytes(data), self.time)

    def _find_routes(self) -> dict[int, list[tuple[Device, Rpdo]]]:
        """Return who receives which COB-ID, by the present configuration."""
        routes: dict[int, list[tuple[Device, Rpdo]]] = {}
        for device in self._devices:
            for rpdo in device.rpdos:
                if rpdo.valid:
                    routes.setdefault(rpdo.cob_id, []).append((device, rpdo))
        return routes

    def _send(self, cob_id: int, data: bytes) -> None:
        self._bus.send(can.Message(arbitration_id=cob_id, data=data, is_extended_id=False, check=False))

    # Time

    def _run_timers(self, now: float) -> None:
        self._run_faults(now)
        self._run_device_timers(now)

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
        self._routes = None
