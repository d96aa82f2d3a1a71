"""PDOs to samples: one sample per SYNC, in which no frame of another SYNC can stand.

This file uses no bus and no clock. Between `begin` and `close` the first well-formed frame of a PDO enters
the sample. A PDO that missed a SYNC may still answer it after the next one: its frames are held back until
it is known which of them is current (`omnimate.files.logs.answers`), at the latest at `close`.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from omnimate.driver.robot.events import EventLog, NodeCounts
from omnimate.driver.robot.expected_pdos import ExpectedPdo, expected_pdos
from omnimate.driver.robot.gap_log import GapLog
from omnimate.vehicle.bridging import Bridges
from omnimate.vehicle.counters import Counter, counter_law, samples_left_out
from omnimate.vehicle.sample import Sample

if TYPE_CHECKING:
    from omnimate.vehicle.parameters import VehicleParameters
    from omnimate.vehicle.recording import Gap

TRUSTED_AFTER = 100  # SYNCs in a row with an answer, after a miss, before it is waited for at length again
SILENT_TIME = 2.0  # [s] without an answer after which a node is configured again; a boot takes less
SILENT_AFTER = 3  # SYNCs in a row without an answer, before it is called silence and not waited for


class Assembler:
    """The state between two SYNCs: which PDOs have answered, and the position of each counter.

    Args:
        vehicle: Vehicle whose PDOs are assembled.
        events: Log for nodes that fall silent and answer again; a new one where it is None.
        counts: Frame counters by node id, to be shared with others; new ones where it is None.

    Attributes:
        vehicle: Vehicle whose PDOs are assembled.
        events: Log for nodes that fall silent and answer again.
        counts: Frame counters by node id.
        pdos: Expected PDOs by COB-ID.
        is_open: Whether a SYNC has been sent and its sample is not closed.
        started: Time of the first SYNC [s]; None before it.
        is_synchronous: Whether PDOs answer SYNC; otherwise each is current when it comes, and none is late.
    """

    def __init__(
        self,
        vehicle: VehicleParameters,
        events: EventLog | None = None,
        counts: dict[int, NodeCounts] | None = None,
    ) -> None:
        self.vehicle = vehicle
        self.events = EventLog() if events is None else events
        self.counts = {} if counts is None else counts
        for encoder in vehicle.encoders:
            self.counts.setdefault(encoder.node, NodeCounts())
        self.pdos = expected_pdos(vehicle, self.counts)
        self.is_open, self.is_synchronous = False, True
        self.started: float | None = None
        self._index, self._time = 0, 0.0
        width = len(vehicle.channels)
        self._counters = [Counter(counter_law(encoder, vehicle)) for encoder in vehicle.encoders]
        self._bridges = Bridges(vehicle)
        self._gap_log = GapLog(vehicle.channels)
        self._silent: set[int] = set()
        self._long = max(SILENT_AFTER, math.ceil(SILENT_TIME / vehicle.bus.sync_period))  # SYNCs
        self._absent = (math.nan,) * width
        self._nothing = (False,) * width
        # COB-IDs: PDOs that answer reliably are waited for at length, unreliable ones only for a short time.
        self._reliable, self._unreliable = set(self.pdos), set[int]()
        self._waiting: set[int] = set()
        self._waiting_shortly: set[int] = set()
        self._held: set[int] = set()
        self._present = list(self._nothing)
        self._device_time, self._arrival_time = list(self._absent), list(self._absent)

    @property
    def gaps(self) -> list[Gap]:
        """Gaps that have ended, in order of their end."""
        return self._gap_log.gaps

    @property
    def is_complete(self) -> bool:
        """Whether every PDO has answered that does so reliably."""
        return not self._waiting

    @property
    def is_settled(self) -> bool:
        """Whether unreliable PDOs have answered too, and no frame is held back.

        Waiting for a short time may bring them; waiting long for each would slow every sample down.
        """
        return not (self._held or self._waiting_shortly)

    def expect_length(self, cob_id: int, length: int, *, is_timed: bool = False) -> None:
        """Expect exactly this length of a PDO [bytes], after its mapping has been read from the device.

        Before the first frame of this length, longer ones are taken: some devices fill every PDO up to 8
        bytes. With `is_timed` it comes by the device's own timer, more than once per SYNC: the first is
        taken.
        """
        pdo = self.pdos[cob_id]
        pdo.length, pdo.is_mapped, pdo.is_exact, pdo.is_timed = length, True, False, is_timed

    def begin(self, index: int, time: float) -> None:
        """Open a sample; SYNCs that were left out since the last one count as missed.

        Args:
            index: Number of the sample.
            time: Time of its SYNC on the recording's clock [s].
        """
        if self.started is not None:
            left_out = int(samples_left_out(time - self._time, self.vehicle))
            for counter in self._counters if left_out else ():
                counter.skip(left_out)
        self._index, self._time, self.is_open = index, time, True
        if self.started is None:
            self.started = time
        self._waiting = self._reliable.copy()
        self._waiting_shortly = self._unreliable.copy()
        self._present[:] = self._nothing
        self._device_time[:] = self._absent
        self._arrival_time[:] = self._absent
        for pdo in self.pdos.values():
            pdo.answered = pdo.heard = False
            pdo.held, pdo.frames = None, 0

    def frame(self, cob_id: int, data: bytes | bytearray, device_time: float, arrival_time: float) -> None:
        """Take a frame of an expected PDO, at any time and of any content.

        Args:
            cob_id: COB-ID of the frame.
            data: Data bytes of the frame.
            device_time: Timestamp of the adapter [s].
            arrival_time: When the frame was on the bus, on the recording's clock [s].

        Raises:
            KeyError: The COB-ID is not in `pdos`.
        """
        pdo = self.pdos[cob_id]
        length = len(data)
        if length == pdo.length:
            pdo.is_exact = pdo.is_mapped
        elif pdo.is_mapped and not pdo.is_exact and length > pdo.length:
            what = f"PDO {cob_id:03X}h has {length} bytes and its mapping {pdo.length}: the first are taken"
            self.events.add(arrival_time, pdo.node, what)
        if length < pdo.length or (length > pdo.length and pdo.is_exact):
            pdo.counts.wrong_length += 1
            pdo.heard = True
            self._waiting.discard(cob_id)
            self._waiting_shortly.discard(cob_id)
        elif pdo.is_timed and (pdo.answered or not self.is_open):
            pdo.heard = True
        elif pdo.answered:
            pdo.counts.duplicate += 1
        elif not self.is_open:
            self._late(pdo)
        elif pdo.owed.count > pdo.frames:
            pdo.held = (int.from_bytes(data, "little"), device_time, arrival_time)
            pdo.frames += 1
            pdo.heard = True
            self._held.add(cob_id)
            self._waiting_shortly.discard(cob_id)
        else:
            pdo.counts.late += pdo.frames
            pdo.counts.missing -= pdo.frames
            if pdo.frames:
                self._mark_unreliable(pdo)
                self._held.discard(cob_id)
            if not pdo.owed.count:
                pdo.owed.usual = arrival_time - self._time
            pdo.owed.settle()
            self._accept(pdo, int.from_bytes(data, "little"), device_time, arrival_time)

    def close(self) -> Sample:
        """Close the open sample and return it; frames that still come belong to no sample."""
        for cob_id in self._held:
            self._decide(self.pdos[cob_id])
        self._held.clear()
        self.is_open = False
        for pdo in self.pdos.values():
            if not pdo.answered:
                self._missed(pdo)
            elif pdo.cob_id in self._unreliable or pdo.misses:
                self._answers_again(pdo)
        present = tuple(self._present)
        self._bridges.follow(self._counters, self._present)
        self._gap_log.close(present, self._time)
        return Sample(
            self._index,
            self._time,
            tuple([counter.count or 0 for counter in self._counters]),
            present,
            tuple(self._device_time),
            tuple(self._arrival_time),
        )

    def node_booted(self, node: int) -> None:
        """Note that a boot-up of a node was heard, which its PDOs have to confirm."""
        for pdo in self.pdos.values():
            if pdo.node == node:
                pdo.has_booted, pdo.was_started = True, False

    def node_started(self, node: int) -> None:
        """Note that a node, 0 for all, was started, and its PDOs are waited for again."""
        for pdo in self.pdos.values():
            if node in {0, pdo.node}:
                pdo.was_started = pdo.has_booted
                self._unreliable.discard(pdo.cob_id)
                self._reliable.add(pdo.cob_id)

    def is_answering(self, node: int) -> bool:
        """Return whether all PDOs of a node answered the last SYNC."""
        return not any(pdo.misses for pdo in self.pdos.values() if pdo.node == node)

    def silence(self, node: int) -> float:
        """Return for how long the most silent PDO of a node has not answered [s]."""
        misses = max(pdo.misses for pdo in self.pdos.values() if pdo.node == node)
        return misses * self.vehicle.bus.sync_period

    def never_answered(self, node: int) -> bool:
        """Return whether a PDO of a node has not entered any sample."""
        return any(pdo.last is None for pdo in self.pdos.values() if pdo.node == node)

    def take_silent(self) -> set[int]:
        """Return the nodes that have not answered for `SILENT_TIME` since they were last returned."""
        silent, self._silent = self._silent, set()
        return silent

    def gaps_until_now(self) -> tuple[Gap, ...]:
        """Return all gaps; one that is still open ends with the last sample."""
        return self._gap_log.until(self._time)

    def _late(self, pdo: ExpectedPdo) -> None:
        pdo.counts.late += 1
        pdo.counts.missing -= pdo.owed.count > 0
        pdo.owed.late()
        pdo.heard = True
        self._mark_unreliable(pdo)

    def _accept(self, pdo: ExpectedPdo, word: int, device_time: float, arrival_time: float) -> None:
        pdo.answered = pdo.heard = True
        pdo.counts.received += 1
        if pdo.has_booted:
            self._confirm_boot(pdo)
        pdo.last = self._index
        self._waiting.discard(pdo.cob_id)
        self._waiting_shortly.discard(pdo.cob_id)
        for field in pdo.fields:
            column = field.column
            if self._counters[column].step(field.decode(word)):
                self._present[column] = True
                self._device_time[column] = device_time
                self._arrival_time[column] = arrival_time
            else:
                pdo.counts.jumps += 1
                self._gap_log.jumped(column)

    def _confirm_boot(self, pdo: ExpectedPdo) -> None:
        """Believe a boot-up where the PDO stopped, or was started: its counters begin anew."""
        if pdo.last is None or self._index - pdo.last > 1 or pdo.was_started:
            for field in pdo.fields:
                self._counters[field.column].rebase()
                self._gap_log.restarted(field.column, self._time)
        else:
            self.events.add(self._time, pdo.node, "its boot-up is not believed: its PDOs did not stop")
        pdo.has_booted = pdo.was_started = False

    def _decide(self, pdo: ExpectedPdo) -> None:
        """Take the held frame for the answer to this SYNC, or all that are held for late ones."""
        assert pdo.held is not None  # the caller has seen that it is
        if pdo.owed.close(pdo.frames, pdo.held[2] - self._time) is not None:
            self._accept(pdo, *pdo.held)
        else:
            pdo.counts.late += pdo.frames
            pdo.counts.missing += 1 - pdo.frames

    def _missed(self, pdo: ExpectedPdo) -> None:
        for field in pdo.fields:
            self._counters[field.column].step(None)
        if not pdo.heard:
            pdo.counts.missing += 1
            if self.is_synchronous:
                pdo.owed.close(0, math.nan)
        pdo.misses += 1
        self._mark_unreliable(pdo)
        if pdo.misses >= SILENT_AFTER and not pdo.heard:
            self._unreliable.discard(pdo.cob_id)
        if pdo.misses == SILENT_AFTER and self.is_synchronous:
            names = ", ".join(pdo.channels)
            self.events.add(self._time, pdo.node, f"{names}: no valid answer to SYNC")
        if pdo.misses % self._long == 0 and self.is_synchronous:
            self._silent.add(pdo.node)

    def _mark_unreliable(self, pdo: ExpectedPdo) -> None:
        """Wait for a PDO only for a short time, until it has answered many times in a row."""
        pdo.answers = 0
        self._reliable.discard(pdo.cob_id)
        self._unreliable.add(pdo.cob_id)

    def _answers_again(self, pdo: ExpectedPdo) -> None:
        self._unreliable.add(pdo.cob_id)
        pdo.answers += 1
        if pdo.answers >= TRUSTED_AFTER:
            self._unreliable.discard(pdo.cob_id)
            self._reliable.add(pdo.cob_id)
        if pdo.misses >= SILENT_AFTER and self.is_synchronous:
            names = ", ".join(pdo.channels)
            self.events.add(self._time, pdo.node, f"{names}: answers SYNC again after {pdo.misses} without")
        pdo.misses = 0
