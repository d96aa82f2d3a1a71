"""PDOs to samples: one sample per SYNC, without frames of other SYNCs.

There is one compiled function per bus event. The live driver calls them one by one, `assemble_events` for a
log.

Between `open_sample` and `close_sample` the first well-formed frame of a PDO enters the sample. Nothing in
a PDO identifies its SYNC, but a node answers every SYNC once and in order. So after n SYNCs without an
answer, n answers are owed, and the first frames after the next SYNC are held back because they may be late. A
frame is current if it is one more than is owed, if it is the only one after one missed SYNC, or if it is the
only one and came with the node's normal latency. A burst of late answers may start at any time; if it starts
at the normal latency, the frames after the first are late all the same. If a node answers once per SYNC but
later than before, the second such frame is accepted: the owed answers were lost.

Without SYNC, one of the PDOs opens the samples, which `SampleOpener` decides.
"""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import numpy as np

from omnimate.vehicle.bridging import BridgedCounter, bridge, set_partners
from omnimate.vehicle.compiled import Array, IntArray, Record, compiled, layout, record
from omnimate.vehicle.counters import begin_sample, counter_law, counters_of, take_reading

if TYPE_CHECKING:
    from collections.abc import Collection

    from numpy.typing import NDArray

    from omnimate.vehicle.parameters import VehicleParameters
    from omnimate.vehicle.recording import GapReason

MAX_SINGLE_ANSWERS = 2  # successive samples with one frame after which owed answers count as lost
MAX_PDOS = 10  # of one COB-ID in a sample, after which the PDO that opens samples is silent (assumption)
LATENCY_TOLERANCE = 0.25  # [SYNC periods] largest increase of an answer's latency (assumption)
ACCEPTED, HELD, LATE, DUPLICATE, WRONG_LENGTH, REPEATED = range(6)  # fate of a frame
REASONS: tuple[GapReason, ...] = ("missing", "missing", "jump", "reboot")  # by the constants below; 0: no gap
MISSING, JUMP, REBOOT = 1, 2, 3  # causes of a gap; the highest one is reported
NOTHING, BOOTED, STARTED = range(-3, 0)  # kinds of events that are not PDOs


class PdoState:
    """Record of one TPDO: expected length, state, and counts of its frames."""

    cob_id: int  # COB-ID of the PDO
    node: int  # node that sends the PDO
    length: int  # expected length [bytes]
    is_mapped: bool  # whether the length is that of a mapping that was read from the device
    is_exact: bool  # whether longer frames are rejected
    is_timed: bool  # whether the device's event timer sends it more than once per SYNC
    answered: bool  # whether a valid frame entered the open sample
    heard: bool  # whether any frame of the PDO was received since the last SYNC
    frames: int  # number of frames that are held back since the last SYNC
    word: np.uint64  # content of the frame that entered the sample, or of the last one that is held
    device_time: float  # its timestamp of the adapter [s]
    arrival_time: float  # when it was on the bus, on the recording's clock [s]
    owed: int  # SYNCs whose answers may still come
    alone: int  # samples in a row with one frame while answers are owed; counted from the last missed SYNC on
    usual: float  # latency of the last unambiguous answer [s]; nan before the first
    last: int  # number of the sample that it last entered; -1 before the first
    has_booted: bool  # whether a boot-up of its node was heard since then
    was_started: bool  # whether the node was started after that
    has_restarted: bool  # whether the node's counters restart with the frame that entered the sample
    is_boot_doubted: bool  # whether it booted although its PDOs did not stop; reset by the driver
    received: int  # frames that entered a sample
    missing: int  # SYNCs without an answer, not counting late answers
    late: int  # frames received after their sample was closed
    duplicate: int  # further answers to one SYNC
    wrong_length: int  # frames of an impossible length
    jumps: int  # readings that were rejected as impossible


class ChannelState(BridgedCounter):
    """Record of one encoder: its counter, its field in a PDO, and its gap."""

    pdo: int  # place of its PDO
    left: int  # bits by which the PDO is shifted left, so that the field's highest bit is the number's
    right: int  # bits by which it is then shifted right
    signed: bool  # whether the field is signed
    gap: int  # place in `REASONS` of why it has not been read since `last_good`; 0 where it has
    last_good: float  # time of the last sample in which it was read [s]; of the first one before that
    ended_gap: int  # place in `REASONS` of the gap that has ended in this sample; 0 for none
    gap_start: float  # its start [s]


class Cycle:
    """Record of the current sample."""

    period: float  # time between two SYNCs [s]
    number: int  # number of samples opened before it; -1 before the first
    time: float  # time of its SYNC [s]
    is_open: bool  # whether it is open
    is_synchronous: bool  # whether PDOs answer SYNC; otherwise each is current when it comes, none late


class SampleOpener:
    """Which frames open a sample: those of SYNC, or of the PDO that came first.

    Where that PDO is silent while another one of `pdos` goes on, the other one takes its place. With SYNC
    there are no `pdos`.
    """

    def __init__(self, identifier: int, pdos: Collection[int] = ()) -> None:
        self.identifier = identifier  # COB-ID of the frames that open a sample
        self._pdos = pdos
        self._frames = Counter[int]()  # of the other PDOs in this sample, by COB-ID

    def opens(self, identifier: int) -> bool:
        """Return whether the next data frame, of 11 bits, opens a sample."""
        if identifier != self.identifier:
            if identifier not in self._pdos:
                return False
            self._frames[identifier] += 1
            if self._frames[identifier] <= MAX_PDOS:
                return False
            self.identifier = identifier
        self._frames.clear()
        return True


def pdo_lengths(vehicle: VehicleParameters) -> dict[int, int]:
    """Return the length that each TPDO of the vehicle needs [bytes], by COB-ID."""
    ends: dict[int, int] = {}
    for encoder in vehicle.encoders:
        ends[encoder.cob_id] = max(ends.get(encoder.cob_id, 0), encoder.start_bit + encoder.bits)
    return {cob_id: (end + 7) // 8 for cob_id, end in ends.items()}


def assembly_records(vehicle: VehicleParameters) -> tuple[Record, Record, Record]:
    """Return the state before the first SYNC: `Cycle` (1,), `PdoState` (P,) and `ChannelState` (C,)."""
    cycles = record(Cycle)
    cycles["period"], cycles["number"], cycles["is_synchronous"] = vehicle.bus.sync_period, -1, True
    lengths = pdo_lengths(vehicle)
    pdos = np.zeros(len(lengths), layout(PdoState))
    pdos["cob_id"], pdos["length"] = list(lengths), list(lengths.values())
    pdos["usual"], pdos["last"] = np.nan, -1
    channels = counters_of([counter_law(encoder, vehicle) for encoder in vehicle.encoders], ChannelState)
    set_partners(channels, vehicle)
    places = list(lengths)
    for channel, encoder in zip(channels, vehicle.encoders, strict=True):
        channel["pdo"] = places.index(encoder.cob_id)
        pdos["node"][channel["pdo"]] = encoder.node
        channel["left"], channel["right"] = 64 - encoder.start_bit - encoder.bits, 64 - encoder.bits
        channel["signed"] = encoder.signed
    return cycles, pdos, channels


@compiled
def open_sample(cycles: Record, pdos: Record, channels: Record, time: float) -> None:
    """Open a sample at the time of its SYNC [s]; skipped SYNC periods count as missed samples."""
    cycle = cycles[0]
    if cycle.number >= 0:
        left_out = int(max(np.rint((time - cycle.time) / cycle.period) - 1.0, 0.0))
        for column in range(len(channels)):
            channels[column].samples += left_out
    else:
        for column in range(len(channels)):
            channels[column].last_good = time
    cycle.number += 1
    cycle.time, cycle.is_open = time, True
    for place in range(len(pdos)):
        pdo = pdos[place]
        pdo.answered, pdo.heard, pdo.frames, pdo.has_restarted = False, False, 0, False


@compiled
def take_frame(
    cycles: Record,
    pdos: Record,
    place: int,
    word: np.uint64,
    length: int,
    device_time: float,
    arrival_time: float,
) -> int:
    """Process a frame of a PDO, at any time and with any content; return its fate.

    It is one of `length` bytes for the PDO at `place`; `word` are its first 8 bytes as a little-endian
    number, `device_time` is the adapter's timestamp, `arrival_time` when it was on the bus, on the
    recording's clock [s].
    """
    cycle, pdo = cycles[0], pdos[place]
    if length == pdo.length:
        pdo.is_exact |= pdo.is_mapped
    if length < pdo.length or (length > pdo.length and pdo.is_exact):
        pdo.wrong_length += 1
        pdo.heard = True
        return WRONG_LENGTH
    if pdo.is_timed and (pdo.answered or not cycle.is_open):
        return REPEATED
    if pdo.answered:
        pdo.duplicate += 1
        return DUPLICATE
    pdo.heard = True
    if not cycle.is_open:
        pdo.late += 1
        pdo.missing -= pdo.owed > 0
        pdo.owed = max(0, pdo.owed - 1)
        return LATE
    pdo.word, pdo.device_time, pdo.arrival_time = word, device_time, arrival_time
    if pdo.owed > pdo.frames:
        pdo.frames += 1
        return HELD
    pdo.late += pdo.frames
    pdo.missing -= pdo.frames
    if pdo.owed == 0:
        pdo.usual = arrival_time - cycle.time
    _accept(cycle, pdo)
    return ACCEPTED


@compiled
def _accept(cycle: Cycle, pdo: PdoState) -> None:
    """Accept a PDO's frame; a boot-up counts if the PDO had stopped or the node was started."""
    pdo.answered, pdo.owed = True, 0
    pdo.received += 1
    if pdo.has_booted:
        pdo.has_restarted = pdo.last < 0 or cycle.number - pdo.last > 1 or pdo.was_started
        pdo.is_boot_doubted |= not pdo.has_restarted
        pdo.has_booted = False
    pdo.last = cycle.number


@compiled
def close_sample(cycles: Record, pdos: Record, channels: Record) -> None:
    """Close the open sample; later frames belong to no sample."""
    cycle = cycles[0]
    for place in range(len(pdos)):
        pdo = pdos[place]
        if not pdo.answered and (pdo.frames > 0 or not pdo.heard):
            _resolve_held_frames(cycle, pdo)
    for column in range(len(channels)):
        channel = channels[column]
        _read(channel, pdos[channel.pdo])
    bridge(channels, cycle.number)
    for column in range(len(channels)):
        _update_gap(channels[column], cycle.time)
    cycle.is_open = False


@compiled
def _resolve_held_frames(cycle: Cycle, pdo: PdoState) -> None:
    """Accept the held frame as the answer to this SYNC, or count all held frames as late."""
    if cycle.is_synchronous:
        pdo.alone = pdo.alone + 1 if pdo.frames == 1 else 0
        # also where one of the latencies is unknown
        is_usual = not (pdo.arrival_time - cycle.time > pdo.usual + LATENCY_TOLERANCE * cycle.period)
        if pdo.frames == 1 and (pdo.owed == 1 or is_usual or pdo.alone == MAX_SINGLE_ANSWERS):
            _accept(cycle, pdo)
            return
        pdo.owed += 1 - pdo.frames
    pdo.late += pdo.frames
    pdo.missing += 1 - pdo.frames


@compiled
def _read(channel: ChannelState, pdo: PdoState) -> None:
    """Extract and process the reading of a channel from its PDO."""
    begin_sample(channel)
    if not pdo.answered:
        channel.gap = max(channel.gap, MISSING)
        return
    if pdo.has_restarted:
        channel.has_restarted = True
        channel.gap = REBOOT if channel.is_known else channel.gap
    shifted = pdo.word << np.uint64(channel.left)
    if channel.signed:
        take_reading(channel, int(np.int64(shifted) >> channel.right))
    else:
        take_reading(channel, int(np.int64(shifted >> np.uint64(channel.right))))
    if not channel.present:
        pdo.jumps += 1
        channel.gap = max(channel.gap, JUMP)


@compiled
def _update_gap(channel: ChannelState, time: float) -> None:
    """End a channel's gap if it was read."""
    channel.ended_gap = 0
    if channel.present:
        channel.ended_gap, channel.gap_start = channel.gap, channel.last_good
        channel.gap, channel.last_good = 0, time


@compiled
def take_boot(pdos: Record, node: int) -> None:
    """Record a boot-up of a node, to be confirmed by its PDOs."""
    for place in range(len(pdos)):
        if pdos[place].node == node:
            pdos[place].has_booted, pdos[place].was_started = True, False


@compiled
def take_start(pdos: Record, node: int) -> None:
    """Record that a node was started; 0 for all nodes."""
    for place in range(len(pdos)):
        if node in {0, pdos[place].node}:
            pdos[place].was_started = pdos[place].has_booted


@compiled
def assemble_events(
    cycles: Record,
    pdos: Record,
    channels: Record,
    opens: NDArray[np.bool_],
    kinds: NDArray[np.int16],
    words: NDArray[np.uint64],
    lengths: NDArray[np.uint8],
    times: Array,
    counts: IntArray,
    present: NDArray[np.bool_],
    gaps: NDArray[np.uint8],
) -> None:
    """Process all events of a log; every SYNC closes the previous sample, and so does the end of the log.

    Args:
        cycles: Record of the sample before; a fresh one.
        pdos: Records of the PDOs; changed to what they are at the end.
        channels: Records of the channels; likewise.
        opens: Whether an event opens a sample, shape `(E,)`; the first does.
        kinds: The place of the PDO, `BOOTED`, `STARTED` or `NOTHING`, shape `(E,)`.
        words: The data as one little-endian number, or the node that booted or was started, shape `(E,)`.
        lengths: Number of data bytes, shape `(E,)`.
        times: Time of each event [s], shape `(E,)`.
        counts: Filled with the unwrapped counts, shape `(N, C)`.
        present: Filled with where a reading was accepted, shape `(N, C)`.
        gaps: Filled with the place in `REASONS` of the gap that ended, shape `(N, C)`; 0 for none.
    """
    for event in range(len(opens)):
        kind = kinds[event]
        if opens[event]:
            if cycles[0].is_open:
                _write_sample(cycles, pdos, channels, counts, present, gaps)
            open_sample(cycles, pdos, channels, times[event])
        if kind >= 0:
            take_frame(cycles, pdos, kind, words[event], int(lengths[event]), times[event], times[event])
        elif kind == BOOTED:
            take_boot(pdos, int(words[event]))
        elif kind == STARTED:
            take_start(pdos, int(words[event]))
    _write_sample(cycles, pdos, channels, counts, present, gaps)


@compiled
def _write_sample(
    cycles: Record,
    pdos: Record,
    channels: Record,
    counts: IntArray,
    present: NDArray[np.bool_],
    gaps: NDArray[np.uint8],
) -> None:
    close_sample(cycles, pdos, channels)
    row = cycles[0].number
    for column in range(len(channels)):
        counts[row, column] = channels[column].count
        present[row, column] = channels[column].present
        gaps[row, column] = channels[column].ended_gap
