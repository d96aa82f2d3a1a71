"""Keeps the last minute of frames, events and commands in memory, and writes it down after a fault."""

from __future__ import annotations

import math
import os
import shutil
import struct
import time
from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from omnimate.driver.robot.recorder import frame_flags
from omnimate.files.logs.formats.candump_text import candump_text
from omnimate.files.logs.frames import Frames
from omnimate.files.logs.writing import written_whole
from omnimate.files.recordings.events_jsonl import EVENTS, RecordedEvent, write_events
from omnimate.files.recordings.folder import LOG, VEHICLE
from omnimate.vehicle.file import save_vehicle

if TYPE_CHECKING:
    import can

    from omnimate.driver.canopen.network import FrameSink
    from omnimate.driver.robot.events import EventLog
    from omnimate.vehicle.parameters import VehicleParameters

BEFORE, AFTER = 60.0, 5.0  # [s] that a folder holds before and after its fault
INTERVAL = 60.0  # [s] between two folders, at most `BEFORE`: each begins where the one before it ends
MAX_FRAMES = 600_000  # in memory: `BEFORE` and `AFTER` of a full bus of 1 Mbit/s; 45 MB
MAX_EVENTS = 20_000  # in memory, with the commands
MAX_FOLDERS = 20  # on disk; the oldest is removed for a new one
BATCH, PAUSE = 256, 0.005  # frames that are written at a time; [s] after them, left to the thread of SYNC
_PATTERN = "flight-????????T??????.???Z"
_PACKED = struct.Struct("<dIBB8s")  # bytes, in which the garbage collector does not search for references
_TIME = struct.Struct("<d")
_COLUMNS = np.dtype(
    [("time", "<f8"), ("can_id", "<u4"), ("flags", "u1"), ("length", "u1"), ("data", "u1", (8,))]
)


class FlightRecorder:
    """Records frames, events and commands in memory; the driver calls it in its thread.

    The first fault of a burst has a recording folder `flight-<UTC time of the fault>` written in a thread,
    with `AFTER` seconds more. A fault within `INTERVAL` of the last folder waits until that has passed, and
    all that was recorded since is in its folder. A driver that ends writes it at once, but not within
    `INTERVAL` of a folder of another driver: a robot that fails whenever it is opened keeps its first fault.
    What cannot be written is an event of the log.
    """

    def __init__(
        self,
        folder: Path | str,
        vehicle: VehicleParameters,
        events: EventLog,
        recorder: FrameSink | None = None,
    ) -> None:
        """Record the events of a log from now on.

        Args:
            folder: Folder of the folders of one robot; it is made with the first one.
            vehicle: Vehicle as its owner believes it to be.
            events: Log whose events are recorded, and which gets what cannot be written.
            recorder: Gets every frame, too; None for none.
        """
        self._folder, self._vehicle, self._log, self._recorder = Path(folder), vehicle, events, recorder
        events.listener = self.event
        self._frames, self._events = _memory()
        self._earlier = max((path.name for path in self._folder.glob(_PATTERN)), default="")
        self._latest = self._written = -math.inf
        self._fault: float | None = None
        self._speeds = (0.0,) * len(vehicle.wheels)
        self._executor = ThreadPoolExecutor(max_workers=1, thread_name_prefix="flight recorder")
        self._jobs: list[Future[None]] = []

    def use(self, vehicle: VehicleParameters) -> None:
        """Take the vehicle as its encoders describe it."""
        self._vehicle = vehicle
        if self._recorder is not None:
            self._recorder.use(vehicle)

    def frame(self, at: float, message: can.Message) -> None:
        """Record a frame that was on the bus at time `at` [s], as `Recorder.frame` does.

        Raises:
            OSError: The other recorder's disk refuses; the frame is in memory all the same.
        """
        if not message.is_fd:
            self._keep(at, message)
        if self._recorder is not None:
            self._recorder.frame(at, message)

    def _keep(self, at: float, message: can.Message) -> None:
        self._latest = max(at, self._latest)
        frames = self._frames
        frames.append(
            _PACKED.pack(
                self._latest,
                message.arbitration_id,
                frame_flags(message),
                message.dlc,
                bytes(message.data),
            )
        )
        while _TIME.unpack_from(frames[0])[0] < self._latest - BEFORE - AFTER:
            frames.popleft()

    def event(self, time: float, node: int | None, what: str, *, is_fault: bool) -> None:
        """Record an event of a node, None for the bus, at `time` [s]; the first fault asks for a folder.

        Of the same event several times in a row the first is kept: a full disk is one for each frame.
        """
        if self._events and (self._events[-1].node, self._events[-1].what) == (node, what):
            return
        self._events.append(RecordedEvent(time, node, what, "fault" if is_fault else "event"))
        if is_fault and self._fault is None:
            self._fault = time

    def poll(self, now: float, speeds: tuple[float, ...]) -> None:
        """Record a new command [rad/s] and begin to write a folder that is due, once per SYNC, `now` [s]."""
        if speeds != self._speeds:
            self._speeds = speeds
            pairs = zip(self._vehicle.wheels, speeds, strict=True)
            words = ", ".join(f"{wheel} {speed:.3f}" for wheel, speed in pairs)
            self._events.append(RecordedEvent(now, None, f"commanded {words} rad/s", "command"))
        if self._fault is not None and now >= max(self._fault + AFTER, self._written + INTERVAL):
            self._write(now)
        if self._jobs and self._jobs[0].done():
            self._report(self._jobs.pop(0), now)

    def close(self, now: float) -> None:
        """Write the folder of a fault that is still waiting, and wait until all is written."""
        if self._fault is not None:
            self._write(now)
        self._executor.shutdown(wait=True)
        while self._jobs:
            self._report(self._jobs.pop(0), now)

    def _write(self, now: float) -> None:
        """Hand the memory to the thread and go on with an empty one, unless another driver just wrote."""
        assert self._fault is not None  # the caller has checked
        if _name(now - INTERVAL) < self._earlier <= _name(now):
            return
        path = self._folder / _name(self._fault)
        events = [event for event in self._events if event.time >= now - BEFORE - AFTER]
        self._jobs.append(self._executor.submit(_write_folder, path, self._vehicle, self._frames, events))
        self._frames, self._events = _memory()
        self._fault, self._written = None, now

    def _report(self, job: Future[None], now: float) -> None:
        error = job.exception()
        if error is not None:
            what = f"flight recorder: {self._folder} cannot be written: {error}"
            self._log.add(now, None, what)


def _memory() -> tuple[deque[bytes], deque[RecordedEvent]]:
    return deque(maxlen=MAX_FRAMES), deque(maxlen=MAX_EVENTS)


def _name(time: float) -> str:
    """Return the name of a folder; the order of the names is that of the times."""
    return f"flight-{datetime.fromtimestamp(time, UTC):%Y%m%dT%H%M%S.%f}"[:-3] + "Z"


def _write_folder(
    path: Path, vehicle: VehicleParameters, packed: deque[bytes], events: list[RecordedEvent]
) -> None:
    """Write a recording folder with `events.jsonl`, in place of the oldest one where there are many."""
    for oldest in sorted(path.parent.glob(_PATTERN))[: 1 - MAX_FOLDERS]:
        shutil.rmtree(oldest)
    path.mkdir(parents=True)
    try:
        save_vehicle(vehicle, path / VEHICLE)
        write_events(events, path / EVENTS)
        with written_whole(path / LOG) as partial:  # the last file: with it the folder is a recording
            _write_log(partial, packed)
    except BaseException:
        shutil.rmtree(path, ignore_errors=True)
        raise


def _write_log(path: Path, packed: deque[bytes]) -> None:
    """Write packed frames as candump prints them, and remove them from memory one by one."""
    with path.open("wb") as file:
        while packed:
            batch = [packed.popleft() for _ in range(min(BATCH, len(packed)))]
            rows = np.frombuffer(b"".join(batch), _COLUMNS)
            frames = Frames(
                rows["time"],
                rows["can_id"],
                rows["length"],
                rows["data"],
                rows["flags"],
                np.zeros(len(rows), np.uint8),
            )
            file.writelines(candump_text(frames))
            time.sleep(PAUSE)
        file.flush()
        os.fsync(file.fileno())
