"""The bus of a simulated vehicle with its faults, on one time, which passes only while the driver waits.

The driver is the real one with its wall clock, and its thread for dialogues with restarted nodes. That thread
runs only while the driver waits for a frame, so that a session repeats exactly.
"""

from __future__ import annotations

import errno
import heapq
import io
import math
import os
import queue
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from contextlib import ExitStack, contextmanager
from functools import partial
from itertools import count
from pathlib import Path
from random import Random
from types import SimpleNamespace
from typing import Any, cast
from unittest import mock

import can
from canopen.sdo import client

from omnimate.driver.errors import BusError
from omnimate.driver.robot import driver as driver_module
from omnimate.driver.robot import recovery as recovery_module
from omnimate.files.logs.formats import candump_writer
from omnimate.vcan_sim.coupled_bus import CoupledBus
from omnimate.vcan_sim.faults import Reboot
from omnimate.vcan_sim.floor import SMOOTH
from omnimate.vcan_sim.nodes.device import SYNC_ID
from omnimate.vcan_sim.nodes.drive import DriveDevice
from omnimate.vcan_sim.plant import Plant
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.arcs import PoseTuple
from omnimate.vehicle.parameters import TruckName, VehicleParameters
from studies.faults.script import DEVICE_FAULTS, NMT_COMMANDS, Fault

START = 1000.0  # [s]
FRAME = 0.00025  # [s] of a frame of 8 bytes at 500 kbit/s
SECOND_SYNC = 0.02  # [s] between two SYNCs of another master
BLOCK = 4096  # bytes that a disk writes at once
LOSS = 0.3  # share of the frames that are lost


class PowerCut(BaseException):
    """The driver's computer has lost its power; no code of the driver handles it."""


class World:
    """The simulated vehicle, its bus, and its faults."""

    def __init__(self, vehicle: VehicleParameters, faults: Sequence[Fault], seed: int) -> None:
        self.now = START  # time [s]
        self.vehicle = vehicle  # vehicle on the bus
        self.plant = Plant(Truth(vehicle, SMOOTH), vehicle)  # mechanics of the vehicle
        self.note_poses()
        self.speeds: Sequence[float] = ()  # speeds of the wheels in the last step [rad/s]
        self.active: list[Fault] = []  # faults that have begun and not ended
        self.on_fault: Callable[[Fault], None] = lambda _fault: None  # called when a fault begins
        self.on_step: Callable[[], None] = lambda: None  # called after each step of the plant
        self.worker: Worker | None = None
        self.log: Log | None = None  # the log that is written; None before the first
        self.cut_at: float | None = None  # when the driver's computer lost its power [s]; None while it runs
        self.torn = b""  # what the log holds after that
        self._random = Random(seed)
        self._stepped = self._wire = START
        self._order = count()
        self._frames: list[tuple[float, int, can.Message]] = []  # on their way to the driver
        self._events: list[tuple[float, int, Callable[[], None]]] = []
        self._adapter: Adapter | None = None
        for fault in faults:
            self.at(START + fault.at, partial(self._begin, fault))

    def start(self) -> None:
        """Switch the vehicle on; in the time of this world."""
        plant = cast("Plant", self)  # it steps, and has raw counts
        self._bus = CoupledBus(self.vehicle, plant, clock="wall")
        self.devices = self._bus.simulated.devices
        drives = [self.devices[self.vehicle.drive(wheel).node] for wheel in self.vehicle.wheels]
        self.drives = [drive for drive in drives if isinstance(drive, DriveDevice)]
        self.at(self.now, self._coast)
        self._collect()

    # The plant moves by the time that has passed, with or without SYNC.

    def step(self, wheel_speeds: Sequence[float], _dt: float) -> None:
        self.plant.step(wheel_speeds, self.now - self._stepped)
        self.speeds, self._stepped = wheel_speeds, self.now
        self.on_step()

    def raw_counts(self) -> Sequence[int]:
        return self.plant.raw_counts()

    def note_poses(self) -> None:
        """Keep the poses that belong to the sample of the SYNC that was sent."""
        self.poses: dict[TruckName, PoseTuple] = {}  # true pose of each truck at the driver's last SYNC
        for truck in self.vehicle.trucks:
            x, y, theta = self.plant.pose(truck).tolist()
            self.poses[truck] = x, y, theta

    def _coast(self) -> None:
        """Let the drives turn where no SYNC has come for a period."""
        period = self.vehicle.bus.sync_period
        if self.now - self._stepped >= 1.5 * period:
            self.step([drive.advance(self.now - self._stepped) for drive in self.drives], period)
        self.at(self.now + period, self._coast)

    # Time

    def time(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        if self.worker is not None and self.worker.is_here():
            self.worker.wait(lambda: False, seconds)
            return
        end = self.now + seconds
        while self.now < end:
            self.advance(end)

    def at(self, when: float, happen: Callable[[], None]) -> None:
        """Let something happen at a time [s]."""
        heapq.heappush(self._events, (when, next(self._order), happen))

    def advance(self, end: float) -> None:
        """Let time pass until `end` [s] or until something has happened."""
        wait = self._bus.simulated.wait()
        due = min(end, self._events[0][0], math.inf if wait is None else self.now + wait)
        if self._frames and self._frames[0][0] > self.now:
            due = min(due, self._frames[0][0])
        worker = self.worker
        if worker is not None:
            due = self.now if worker.is_ready() else min(due, worker.deadline)
        self.now = max(self.now, due)
        while self._events[0][0] <= self.now:
            heapq.heappop(self._events)[2]()
        self._bus.simulated.poll()
        self._collect()
        if worker is not None and worker.is_ready():
            worker.resume()

    # Frames

    def open(self, url: str, _bitrate: int | None = None) -> can.BusABC:
        """Return the driver's adapter; BusError where it is away, PowerCut without power."""
        self.check_power()
        if self.has_fault("adapter", "power"):
            raise BusError(url, "the adapter is away")
        self._frames.clear()
        self._adapter = Adapter(self)
        return self._adapter

    def take(self, message: can.Message) -> None:
        """Bring a frame of the driver to the devices."""
        self._wire = max(self.now, self._wire) + FRAME
        self._bus.send(message)
        self._collect()

    def receive(self, end: float) -> can.Message | None:
        """Return the next frame for the driver, None where none comes until `end` [s]."""
        while True:
            if self._frames and self._frames[0][0] <= self.now:
                return heapq.heappop(self._frames)[2]
            if self.now >= end:
                return None
            self.advance(end)

    def has_fault(self, *kinds: str, node: int = 0) -> bool:
        """Return whether one of these faults is active, of a node."""
        return any(fault.kind in kinds and fault.node == node for fault in self.active)

    def _collect(self) -> None:
        """Put what the devices have sent on the wire."""
        while (message := self._bus.recv(0.0)) is not None:
            self._put(message)
            node = message.arbitration_id & 0x7F
            if self.has_fault("twin", node=node):
                self._put(message)

    def _put(self, message: can.Message) -> None:
        self._wire = at = max(self.now, self._wire) + FRAME
        if self.has_fault("adapter", "power") or (self.has_fault("loss") and self._random.random() < LOSS):
            return
        message.timestamp = at
        held = [START + fault.at + fault.duration for fault in self.active if fault.kind == "burst"]
        heapq.heappush(self._frames, (max(at, *held, 0.0), next(self._order), message))

    def inject(self, can_id: int, data: bytes = b"") -> None:
        """Send a frame of another device to all."""
        message = can.Message(arbitration_id=can_id, data=data, is_extended_id=False)
        self.take(message)
        self._put(message)

    # Faults

    def _begin(self, fault: Fault) -> None:
        self.on_fault(fault)
        self.active.append(fault)
        self.at(self.now + fault.duration, partial(self.active.remove, fault))
        simulated = self._bus.simulated
        if fault.kind in DEVICE_FAULTS:
            simulated.inject(DEVICE_FAULTS[fault.kind](node=fault.node, duration=fault.duration))
        elif fault.kind in NMT_COMMANDS:
            self.inject(0x000, bytes((NMT_COMMANDS[fault.kind], fault.node)))
        elif fault.kind == "torn write" and self.cut_at is None:
            self.cut_at, self.torn = self.now, b"" if self.log is None else self.log.tear(self._random)
        elif fault.kind == "trip":
            self.devices[fault.node].master_lost()
        elif fault.kind == "sync":
            self._second_sync(self.now + fault.duration)
        elif fault.kind == "power":
            for node in self.devices:
                simulated.inject(Reboot(node=node, duration=fault.duration))
        if fault.kind in {"adapter", "power"}:
            self._frames.clear()
            if self._adapter is not None:
                self._adapter.is_away = True

    def check_power(self) -> None:
        if self.cut_at is not None:
            raise PowerCut

    def check_space(self) -> None:
        if self.has_fault("disk full"):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def fsync(self, handle: int) -> None:
        self.check_space()
        if self.log is not None and not self.log.closed and os.path.sameopenfile(handle, self.log.fileno()):
            self.log.synced = os.fstat(handle).st_size

    def _second_sync(self, end: float) -> None:
        self.inject(SYNC_ID)
        if self.now + SECOND_SYNC < end:
            self.at(self.now + SECOND_SYNC, partial(self._second_sync, end))


class Adapter(can.BusABC):
    """The driver's end of the bus; once it has been away, it must be opened again."""

    def __init__(self, world: World) -> None:
        self.is_away = False
        self._world = world
        super().__init__(channel="simulated")

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        del timeout
        self._check()
        self._world.take(msg)
        if msg.arbitration_id == SYNC_ID:
            self._world.note_poses()

    def recv(self, timeout: float | None = None) -> can.Message | None:
        self._check()
        message = self._world.receive(self._world.now + (timeout or 0.0))
        self._check()
        return message

    def _check(self) -> None:
        self._world.check_power()
        if self.is_away:
            raise can.CanOperationError("the adapter has been unplugged")


class Worker:
    """Stands for a ThreadPoolExecutor of one thread, which runs only while the driver waits."""

    def __init__(self, world: World, **_options: Any) -> None:  # noqa: ANN401  # those of the executor
        self.deadline = 0.0  # time at which the thread waits no longer [s]
        self._world = world
        self._awaits: Callable[[], bool] = lambda: True
        self._turn, self._back = threading.Semaphore(0), threading.Semaphore(0)
        self._thread: threading.Thread | None = None

    def submit(self, work: Callable[..., Any], *arguments: object) -> Future[Any]:
        future: Future[Any] = Future()
        self._awaits = lambda: True
        self._thread = threading.Thread(target=self._run, args=(future, work, arguments), daemon=True)
        self._thread.start()
        self._world.worker = self
        return future

    def shutdown(self, **_options: object) -> None:
        while self._world.worker is self:
            self._world.advance(math.inf)

    def is_ready(self) -> bool:
        """Return whether what the thread waits for is there, or its time is over."""
        return self._awaits() or self._world.now >= self.deadline

    def resume(self) -> None:
        """Let the thread run until it waits or ends."""
        self._turn.release()
        self._back.acquire()

    def is_here(self) -> bool:
        """Return whether the thread is the one that asks."""
        return threading.current_thread() is self._thread

    def wait(self, awaits: Callable[[], bool], timeout: float) -> None:
        """Wait in the thread."""
        self._awaits, self.deadline = awaits, self._world.now + timeout
        self._back.release()
        self._turn.acquire()

    def _run(self, future: Future[Any], work: Callable[..., Any], arguments: Sequence[object]) -> None:
        self._turn.acquire()
        try:
            future.set_result(work(*arguments))
        except BaseException as error:  # noqa: BLE001  # as an executor
            future.set_exception(error)
        self._world.worker = None
        self._back.release()


class Log(io.FileIO):
    """The file of a log, on the disk of a world."""

    def __init__(self, world: World, path: Path | str) -> None:
        super().__init__(path, "wb")
        self._world, self._place = world, Path(path)
        self.synced = 0  # number of bytes that are on the disk for certain
        world.log = self

    def write(self, data: Any) -> int:  # noqa: ANN401  # any buffer
        self._world.check_space()
        return super().write(data)

    def tear(self, random: Random) -> bytes:
        """Return what a power cut leaves: each block that was not synced is there or zero, up to any byte."""
        content = self._place.read_bytes() if self._place.exists() else b""
        kept = bytearray(content[: random.randint(min(self.synced, len(content)), len(content))])
        for start in range(self.synced, len(kept), BLOCK):
            if random.random() < 0.5:
                kept[start : start + BLOCK] = bytes(len(kept[start : start + BLOCK]))
        return bytes(kept)


class Passes(threading.Event):
    """An event for which a loop waits in vain once, and then ends."""

    _is_second = True

    def wait(self, _timeout: float | None = None) -> bool:
        self._is_second = not self._is_second
        return self._is_second


class LogThread:
    """Stands for the thread that syncs a log: its loop runs at its interval in the time of the world."""

    def __init__(
        self, world: World, target: Callable[[float], None], args: tuple[float], **_: object
    ) -> None:
        self._world, self._loop, self._interval = world, target, args[0]
        self._is_over = False

    def start(self) -> None:
        self._world.at(self._world.now + self._interval, self._pass)

    def join(self) -> None:
        self._is_over = True

    def _pass(self) -> None:
        if not self._is_over:
            self._loop(self._interval)
            self.start()


class Answers(queue.Queue[Any]):
    """A queue of SDO answers for which a worker waits in the time of the world."""

    def __init__(self, world: World) -> None:
        super().__init__()
        self._world = world

    def get(self, block: bool = True, timeout: float | None = None) -> Any:  # noqa: ANN401
        worker = self._world.worker
        if block and worker is not None and worker.is_here() and self.empty():
            worker.wait(lambda: not self.empty(), timeout or 0.0)
        return super().get(block=False)


@contextmanager
def in_time_of(world: World) -> Iterator[None]:
    """Let the host's clocks and disk, the driver's adapter and its threads be those of a world."""
    answers = SimpleNamespace(Queue=partial(Answers, world), Empty=queue.Empty)
    threads = SimpleNamespace(
        Lock=threading.Lock,
        Event=Passes,
        Thread=partial(LogThread, world),
        current_thread=threading.current_thread,
    )

    def log_path(path: Path) -> SimpleNamespace:
        return SimpleNamespace(suffix=path.suffix, open=lambda _mode: io.BufferedWriter(Log(world, path)))

    with ExitStack() as patches:
        for place, name, stand_in in (
            (time, "monotonic", world.time),
            (time, "time", world.time),
            (time, "sleep", world.sleep),
            (driver_module, "open_bus", world.open),
            (recovery_module, "ThreadPoolExecutor", partial(Worker, world)),
            (client, "queue", answers),
            (os, "fsync", world.fsync),
            (candump_writer, "threading", threads),
            (candump_writer, "Path", log_path),
        ):
            patches.enter_context(mock.patch.object(place, name, stand_in))
        yield
