"""Assembly of a log's frames to samples: every SYNC opens one, and the encoders' PDOs fill it.

A PDO belongs to the last SYNC before it. Of two in one sample the first counts, the other is a duplicate;
where a sample before it got none, the first may be that one's late answer (`omnimate.vehicle.assembly`). A
PDO's length is the commonest one in the log that holds all of its fields; others never enter a sample. Frames
before the first SYNC are ignored. A log without any SYNC is cut at the PDO that comes first,
or at another one while that is silent.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.files.logs.canopen_words import BOOT_UP, HEARTBEAT, NMT_START
from omnimate.files.logs.decoding import drive_conversion
from omnimate.files.logs.frame_classes import classify, is_class
from omnimate.files.recordings.readings import Events, recording_of_events
from omnimate.vehicle.assembly import BOOTED, NOTHING, STARTED, SampleOpener, assembly_records
from omnimate.vehicle.errors import RecordingError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.files.logs.frames import Frames
    from omnimate.vehicle.compiled import Record
    from omnimate.vehicle.parameters import VehicleParameters
    from omnimate.vehicle.recording import Recording

    Rows = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class PdoTraffic:
    """Statistics of the PDOs of one COB-ID.

    `used` frames entered a sample, `missing` are samples without one, `late` frames came after the next SYNC,
    `duplicate` ones into a sample that had one; those of `wrong_length` are too short or unlike the others,
    and `restarts` are boot-ups of the node.
    """

    cob_id: int
    node: int
    used: int
    missing: int
    late: int
    duplicate: int
    wrong_length: int
    restarts: int


@dataclass(frozen=True, slots=True)
class Assembly:
    """A recording assembled from a log, with statistics of the log.

    The recording is without poses and run; PDOs are in the order of the vehicle's file; `unknown_pdos` has
    the frames of other PDOs, by COB-ID.
    """

    recording: Recording
    pdos: tuple[PdoTraffic, ...]
    unknown_pdos: dict[int, int]


@dataclass(frozen=True, slots=True)
class _Log:
    """The frames of one bus, and which sample each belongs to.

    Attributes:
        frames: The frames in their order on the bus.
        classes: Class of each frame as an index into `CLASSES`, shape `(F,)`.
        opens: Whether a frame opens a sample, shape `(F,)`.
        owner: Sample that each frame belongs to, shape `(F,)`; -1 before the first.
        has_sync: Whether PDOs answer SYNC; otherwise each is current when it comes, and none is late.
    """

    frames: Frames
    classes: NDArray[np.uint8]
    opens: NDArray[np.bool_]
    owner: Rows
    has_sync: bool = True

    @property
    def boots(self) -> Rows:
        """Indices of the boot-up messages."""
        frames = self.frames
        is_boot = (frames.length == 1) & (frames.data[:, 0] == BOOT_UP)
        return np.flatnonzero(is_class(self.classes, "heartbeat") & is_boot)

    @property
    def starts(self) -> Rows:
        """Indices of the NMT commands that start a node, or all."""
        frames = self.frames
        is_start = (frames.length == 2) & (frames.data[:, 0] == NMT_START)
        return np.flatnonzero(is_class(self.classes, "NMT") & is_start)

    def pdo_rows(self, cob_id: int) -> Rows:
        """Return the indices of the frames of a PDO."""
        return np.flatnonzero((self.frames.can_id == cob_id) & is_class(self.classes, "PDO"))


def assemble(frames: Frames, vehicle: VehicleParameters, source: str = "can.log") -> Assembly:
    """Return the recording of a log with statistics.

    The frames are in their order on the bus; messages name the source.

    Raises:
        RecordingError: The log holds neither a SYNC nor a PDO of this vehicle.
    """
    log = _cut(_of_one_bus(frames, vehicle), vehicle, source)
    records = assembly_records(vehicle)
    events, commands, booted = _events(log, records), _commands(log, vehicle), log.frames.can_id[log.boots]
    recording = recording_of_events(vehicle, records, events, commands, source)
    return Assembly(recording, tuple(_traffic(pdo, booted) for pdo in records[1]), _tally_of_unknown(log))


def _of_one_bus(frames: Frames, vehicle: VehicleParameters) -> Frames:
    """Return the frames of the interface on which most of the vehicle's PDOs are."""
    if len(frames.channels) == 1:
        return frames
    hits = np.isin(frames.can_id, [encoder.cob_id for encoder in vehicle.encoders])
    busiest = int(np.argmax(np.bincount(frames.channel[hits], minlength=len(frames.channels))))
    return frames.select(frames.channel == busiest)


def _cut(frames: Frames, vehicle: VehicleParameters, source: str) -> _Log:
    """Divide a log into samples."""
    classes = classify(frames, vehicle)
    opens = is_class(classes, "SYNC")
    has_sync = bool(opens.any())
    if not has_sync:
        wanted = sorted({encoder.cob_id for encoder in vehicle.encoders})
        rows = np.flatnonzero(np.isin(frames.can_id, wanted) & is_class(classes, "PDO"))
        if len(rows) == 0:
            seen = ", ".join(f"{can_id:03X}h" for can_id in np.unique(frames.can_id)[:20].tolist())
            names = ", ".join(f"{cob_id:03X}h" for cob_id in wanted)
            raise RecordingError(
                source,
                f"neither SYNC (080h) nor a PDO of this vehicle ({names}) in it, but {seen or 'nothing'}",
            )
        cob_ids = frames.can_id[rows].tolist()
        opener = SampleOpener(cob_ids[0], wanted)
        opens[rows] = [opener.opens(cob_id) for cob_id in cob_ids]
    return _Log(frames, classes, opens, np.cumsum(opens) - 1, has_sync)


def _events(log: _Log, records: tuple[Record, Record, Record]) -> Events:
    """Return the events of a log; set the lengths of the PDOs in the records."""
    cycles, pdos, _ = records
    cycles["is_synchronous"] = log.has_sync
    kinds, words = np.full(len(log.frames), NOTHING, np.int16), log.frames.words().copy()
    for place, cob_id in enumerate(pdos["cob_id"].tolist()):
        rows = log.pdo_rows(cob_id)
        kinds[rows] = place
        needed = pdos["length"][place]
        usable = log.frames.length[rows[log.owner[rows] >= 0]]
        usable = usable[usable >= needed]
        pdos["length"][place] = np.argmax(np.bincount(usable)) if len(usable) else needed
    pdos["is_mapped"] = pdos["is_exact"] = True
    boots, starts = log.boots, log.starts
    kinds[boots], words[boots] = BOOTED, log.frames.can_id[boots] - HEARTBEAT
    kinds[starts], words[starts] = STARTED, log.frames.data[starts, 1]
    events = np.flatnonzero(log.opens | (kinds != NOTHING))
    events = events[log.owner[events] >= 0]
    frames = log.frames
    return Events(log.opens[events], kinds[events], words[events], frames.length[events], frames.time[events])


def _traffic(pdo: Record, booted: NDArray[np.uint32]) -> PdoTraffic:
    """Return the statistics of the PDOs of one record; `booted` are the COB-IDs of all boot-ups, `(B,)`."""
    names = "cob_id", "node", "received", "missing", "late", "duplicate", "wrong_length"
    restarts = int(np.count_nonzero(booted == HEARTBEAT + pdo["node"]))
    return PdoTraffic(*[*(int(pdo[name]) for name in names), restarts])


def _commands(log: _Log, vehicle: VehicleParameters) -> NDArray[np.float64] | None:
    """Return the wheel speeds [rad/s] last commanded before each sample; nan before the first command."""
    openers = np.flatnonzero(log.opens)
    commands = np.full((len(openers), len(vehicle.wheels)), np.nan)
    for drive in vehicle.drives:
        rows = log.pdo_rows(drive.cob_id)
        first = drive.start_bit // 8
        rows = rows[log.frames.length[rows] >= first + 4]
        speeds = (
            log.frames.data[rows, first : first + 4].copy().view("<i4")[:, 0] * drive_conversion(drive).factor
        )
        last = np.searchsorted(rows, openers) - 1
        commands[last >= 0, vehicle.wheels.index(drive.wheel)] = speeds[last[last >= 0]]
    return None if np.isnan(commands).all() else commands


def _tally_of_unknown(log: _Log) -> dict[int, int]:
    unknown = log.frames.can_id[is_class(log.classes, "unknown PDO")]
    identifiers, numbers = np.unique(unknown, return_counts=True)
    return dict(zip(identifiers.tolist(), numbers.tolist(), strict=True))
