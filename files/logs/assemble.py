"""From the frames of a log to samples: every SYNC opens one, and the encoders' PDOs fill it.

A PDO belongs to the last SYNC before it. Of two in one sample the first counts, the other is a duplicate;
where a sample before it got none, the first may be that one's late answer (`omnimate.files.logs.answers`). A
PDO's length is the commonest one in the log that holds all of its fields; others never enter a sample. Frames
before the first SYNC are ignored. A log without any SYNC is cut at the PDO that comes first.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.files.logs.answers import current
from omnimate.files.logs.canopen_words import NMT_START, SYNC_ID
from omnimate.files.logs.frame_classes import CLASSES, FrameClass, classify, is_class
from omnimate.files.logs.gaps import gaps_of
from omnimate.files.logs.pdo_fields import decode
from omnimate.files.logs.pdo_units import drive_conversion
from omnimate.vehicle.bridging import bridge
from omnimate.vehicle.counters import counter_law, samples_left_out, unwrap
from omnimate.vehicle.errors import RecordingError
from omnimate.vehicle.recording import Recording

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.files.logs.frames import Frames
    from omnimate.vehicle.parameters import Encoder, VehicleParameters
    from omnimate.vehicle.recording import Gap

    Rows = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class PdoTraffic:
    """What became of the PDOs of one COB-ID.

    Attributes:
        cob_id: COB-ID of the PDO.
        node: Node that sends the PDO.
        used: Frames that entered a sample.
        missing: Samples without such a PDO.
        late: Frames that came after the next SYNC.
        duplicate: Further frames in a sample that had one already.
        wrong_length: Frames too short or unlike the others.
        restarts: Boot-up messages of the node.
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
    """A recording made from a log, and what else the log held.

    Attributes:
        recording: The recording, without poses and run.
        pdos: What became of the encoders' PDOs, in the order of the vehicle's file.
        classes: Number of frames of each class in the log.
        unknown_pdos: Number of frames by COB-ID of PDOs that are not the vehicle's.
        early: Number of frames before the first sample.
        other_buses: Number of frames of other interfaces than that with most of the vehicle's PDOs.
        opened_by: COB-ID of what opens a sample; the SYNC's (080h) in any orderly log.
    """

    recording: Recording
    pdos: tuple[PdoTraffic, ...]
    classes: dict[FrameClass, int]
    unknown_pdos: dict[int, int]
    early: int
    other_buses: int
    opened_by: int


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
    def time(self) -> NDArray[np.float64]:
        """Times of the samples, `(N,)` [s]."""
        return self.frames.time[self.opens]

    def pdo_rows(self, cob_id: int) -> Rows:
        """Return the indices of the frames of a PDO."""
        return np.flatnonzero((self.frames.can_id == cob_id) & is_class(self.classes, "PDO"))


@dataclass(frozen=True, slots=True)
class _Answers:
    """The PDOs of one COB-ID that entered a sample.

    Attributes:
        words: Data of the PDOs as little-endian numbers, shape `(K,)`.
        samples: Samples that the PDOs entered, shape `(K,)`.
        restarts: Whether the node had restarted before a sample, shape `(N,)`.
        traffic: What became of all PDOs of this COB-ID.
    """

    words: NDArray[np.uint64]
    samples: Rows
    restarts: NDArray[np.bool_]
    traffic: PdoTraffic


def assemble(frames: Frames, vehicle: VehicleParameters, source: str = "can.log") -> Assembly:
    """Return the samples of a log.

    Args:
        frames: The frames of the log in the order in which they were on the bus.
        vehicle: Robot whose encoders and drives are looked for.
        source: Name of the log, for messages.

    Raises:
        RecordingError: The log holds neither a SYNC nor a PDO of this vehicle.
    """
    mine = _of_one_bus(frames, vehicle)
    log, opener = _cut(mine, vehicle, source)
    time, channels = log.time, vehicle.channels
    counts = np.zeros((len(time), len(channels)), np.int64)
    present, rebased = np.zeros(counts.shape, bool), np.zeros(counts.shape, bool)
    gaps: list[Gap] = []
    left_out = np.concatenate(([0], samples_left_out(np.diff(time), vehicle)))
    answers = {
        cob_id: _answers(
            log,
            [encoder for encoder in vehicle.encoders if encoder.cob_id == cob_id],
            vehicle.bus.sync_period,
        )
        for cob_id in dict.fromkeys(encoder.cob_id for encoder in vehicle.encoders)
    }
    for column, encoder in enumerate(vehicle.encoders):
        answer = answers[encoder.cob_id]
        raw, received = np.zeros(len(time), np.int64), np.zeros(len(time), bool)
        raw[answer.samples], received[answer.samples] = decode(answer.words, encoder), True
        unwrapped = unwrap(raw, counter_law(encoder, vehicle), received, answer.restarts, left_out)
        counts[:, column], present[:, column] = unwrapped.counts, unwrapped.present
        rebased[:, column] = unwrapped.rebased
        gaps += gaps_of(encoder.channel, time, unwrapped.present, received, answer.restarts)
    bridge(vehicle, counts, present, rebased)
    in_order = tuple(sorted(gaps, key=lambda gap: (gap.start, gap.channel)))
    commands = _commands(log, vehicle)
    recording = Recording(vehicle, time, counts, present, None, None, in_order, commands, source)
    return Assembly(
        recording,
        tuple(answer.traffic for answer in answers.values()),
        _tally(log),
        _tally_of_unknown(log),
        int(np.argmax(log.opens)),
        len(frames) - len(mine),
        opener,
    )


def _of_one_bus(frames: Frames, vehicle: VehicleParameters) -> Frames:
    """Return the frames of the interface on which most of the vehicle's PDOs are."""
    if len(frames.channels) == 1:
        return frames
    hits = np.isin(frames.can_id, [encoder.cob_id for encoder in vehicle.encoders])
    busiest = int(np.argmax(np.bincount(frames.channel[hits], minlength=len(frames.channels))))
    return frames.select(frames.channel == busiest)


def _cut(frames: Frames, vehicle: VehicleParameters, source: str) -> tuple[_Log, int]:
    """Cut a log into samples; return it with the COB-ID of what opens them."""
    classes = classify(frames, vehicle)
    opener, opens = SYNC_ID, is_class(classes, "SYNC")
    if not opens.any():
        wanted = sorted({encoder.cob_id for encoder in vehicle.encoders})
        first = np.flatnonzero(np.isin(frames.can_id, wanted) & is_class(classes, "PDO"))
        if len(first) == 0:
            seen = ", ".join(f"{can_id:03X}h" for can_id in np.unique(frames.can_id)[:20].tolist())
            names = ", ".join(f"{cob_id:03X}h" for cob_id in wanted)
            raise RecordingError(
                source,
                f"neither SYNC (080h) nor a PDO of this vehicle ({names}) in it, but {seen or 'nothing'}",
            )
        opener = int(frames.can_id[first[0]])
        opens = (frames.can_id == opener) & is_class(classes, "PDO")
    return _Log(frames, classes, opens, np.cumsum(opens) - 1, opener == SYNC_ID), opener


def _answers(log: _Log, encoders: list[Encoder], period: float) -> _Answers:
    """Pick the PDO of each sample out of the frames of one COB-ID, which several encoders may share."""
    cob_id, node, count = encoders[0].cob_id, encoders[0].node, len(log.time)
    rows = log.pdo_rows(cob_id)
    rows = rows[log.owner[rows] >= 0]
    right = log.frames.length[rows] == _length(log.frames.length[rows], encoders)
    good = rows[right]
    owner = log.owner[good]
    tally = np.bincount(owner, minlength=count)
    begin = np.cumsum(tally) - tally
    latency = np.append(log.frames.time[good] - log.time[owner], np.nan)  # the last one stands for none
    first = latency[np.where(tally > 0, begin, -1)]
    last = latency[np.where(tally > 0, begin + tally - 1, -1)]
    places = current(tally, first, last, period) if log.has_sync else np.where(tally > 0, 0, -1)
    samples = np.flatnonzero(places >= 0)
    used = good[(begin + places)[samples]]
    restarts, number = _restarts(log, used, samples, node)
    late_ones = int(places[samples].sum() + tally[places < 0].sum())
    missing = count - len(samples)
    traffic = PdoTraffic(
        cob_id,
        node,
        used=len(used),
        missing=max(0, missing - late_ones),
        late=late_ones,
        duplicate=len(good) - len(used) - late_ones,
        wrong_length=int((~right).sum()),
        restarts=number,
    )
    return _Answers(log.frames.words()[used], samples, restarts, traffic)


def _length(lengths: NDArray[np.uint8], encoders: list[Encoder]) -> int:
    """Return the length [bytes] of a PDO: the commonest that holds all of its fields."""
    needed = max((encoder.start_bit + encoder.bits + 7) // 8 for encoder in encoders)
    usable = lengths[lengths >= needed]
    return int(np.argmax(np.bincount(usable))) if len(usable) else needed


def _restarts(log: _Log, used: Rows, samples: Rows, node: int) -> tuple[NDArray[np.bool_], int]:
    """Return before which samples a node had restarted, `(N,)`, and how often its boot-up was heard.

    A boot-up is believed where the PDO stopped, so that a SYNC between its frames around the boot-up has no
    answer, or where the node was started before its next frame.
    """
    frames = log.frames
    boots = np.flatnonzero(
        (frames.can_id == 0x700 + node)
        & is_class(log.classes, "heartbeat")
        & (frames.length == 1)
        & (frames.data[:, 0] == 0)
    )
    starts = np.flatnonzero(
        is_class(log.classes, "NMT")
        & (frames.length == 2)
        & (frames.data[:, 0] == NMT_START)
        & np.isin(frames.data[:, 1], (0, node))
    )
    restarts = np.zeros(len(log.time), bool)
    after = np.searchsorted(used, boots)
    for boot, place in zip(boots.tolist(), after.tolist(), strict=True):
        if place == len(used):
            continue
        stopped = place == 0 or samples[place] - samples[place - 1] > 1
        restarts[samples[place]] |= stopped or bool(((starts > boot) & (starts < used[place])).any())
    return restarts, len(boots)


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


def _tally(log: _Log) -> dict[FrameClass, int]:
    numbers = np.bincount(log.classes, minlength=len(CLASSES)).tolist()
    return {name: number for name, number in zip(CLASSES, numbers, strict=True) if number}


def _tally_of_unknown(log: _Log) -> dict[int, int]:
    unknown = log.frames.can_id[is_class(log.classes, "unknown PDO")]
    identifiers, numbers = np.unique(unknown, return_counts=True)
    return dict(zip(identifiers.tolist(), numbers.tolist(), strict=True))
