"""A recording with derived data for export: odometry, IPEC, measured poses, events."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.files.logs.bus_events import BusEvent, BusEvents
from omnimate.files.logs.frames import ERROR
from omnimate.ipec.corrector import correct
from omnimate.ipec.errors import IpecError
from omnimate.vehicle.trajectories import trajectories

if TYPE_CHECKING:
    from collections.abc import Iterator

    from omnimate.files.logs.frames import Frames
    from omnimate.vehicle.parameters import TruckName
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array


@dataclass(frozen=True, slots=True)
class Path:
    """The poses of one truck by one method.

    The method is `odometry` or `ipec`; times are `(N,)` [s], poses x, y, theta [m, m, rad] `(N, 3)`, nan
    where not known yet.
    """

    method: str
    truck: TruckName
    time: Array
    pose: Array

    @property
    def name(self) -> str:
        """Name such as `odometry_a`."""
        return f"{self.method}_{self.truck}"


@dataclass(frozen=True, slots=True)
class Drive:
    """A recording with derived trajectories and events.

    Paths are by odometry, and by IPEC where there is a linkage that can be read; events are gaps, laps and
    bus events in order of time; notes say what is missing, with reasons.
    """

    recording: Recording
    paths: tuple[Path, ...]
    events: tuple[BusEvent, ...]
    notes: tuple[str, ...]


def drive_of(recording: Recording, frames: Frames) -> Drive:
    """Return a recording with its odometry, from the first whole absolute pose where there is one.

    Raises:
        RecordingError: The two wheels of a truck are never present together.
    """
    plain = trajectories(recording)
    paths = [Path("odometry", path.truck, path.time, path.pose) for path in plain]
    notes = []
    if recording.vehicle.linkage is not None:
        try:
            ipec = correct(recording, plain[0].pose[0])
        except IpecError as error:
            notes.append(f"without IPEC: {error}")
        else:
            paths += [Path("ipec", "a", ipec.time, ipec.pose_a), Path("ipec", "b", ipec.time, ipec.pose_b)]
    events = [*_events_of_recording(recording), *_events_of_frames(frames)]
    events.sort(key=lambda event: event.time)
    return Drive(recording, tuple(paths), tuple(events), tuple(notes))


def _events_of_recording(recording: Recording) -> Iterator[BusEvent]:
    for gap in recording.gaps:
        node = recording.vehicle.encoder(gap.channel).node
        what = f"gap of {gap.channel} until {gap.end - gap.start:.3f} s later ({gap.reason})"
        yield BusEvent(gap.start, node, what, is_problem=True)
    for number, lap in enumerate(recording.run.laps if recording.run else (), start=1):
        yield BusEvent(lap.start, None, f"lap {number} begins ({lap.direction})")
        yield BusEvent(lap.end, None, f"lap {number} ends")


def _events_of_frames(frames: Frames) -> Iterator[BusEvent]:
    """Return the events in frames other than process data."""
    function = frames.can_id & 0x780
    may_say = (frames.flags & ERROR > 0) | np.isin(function, (0x000, 0x080, 0x580, 0x600, 0x700))
    return filter(None, map(BusEvents().take, frames.select(np.flatnonzero(may_say))))
