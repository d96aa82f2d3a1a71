"""PDOs to samples: one sample per SYNC, in which no frame of another SYNC can stand.

No bus and no clock in here. Between `begin` and `close` the first well-formed frame of a PDO enters the
sample. A PDO that missed a SYNC may still answer it after the next one, and nothing in the frame tells. So
its next frame is held: where a second one comes, the first was the late one, else it enters at `close`.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from driver.events import EventLog
from driver.fields import NodeCounts, Pdo, pdos_of
from vehicle.bridging import Bridges
from vehicle.counters import Counter, counter_law
from vehicle.recording import Gap
from vehicle.sample import Sample

if TYPE_CHECKING:
    from vehicle.parameters import VehicleParameters
    from vehicle.recording import GapReason

TRUSTED_AFTER = 100  # SYNCs in a row with an answer, after a miss, before it is waited for at length again
SILENT_AFTER = 3  # SYNCs in a row without an answer, before it is called silence and not waited for
MAX_GAPS = 10_000
MAX_SKIP = 100_000  # SYNCs; a longer pause says nothing about where a counter may be


class Assembler:
    """The state between two SYNCs: which PDOs have answered, and where each counter stands.

    Attributes:
        vehicle: whose PDOs are assembled.
        counts: frame counters by node.
        pdos: by COB-ID.
        gaps: closed gaps in order of their end.
        is_open: a SYNC has been sent and its sample is not closed.
        started: time of the first SYNC [s]; None before it.
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
        self.pdos = pdos_of(vehicle, self.counts)
        self.gaps: list[Gap] = []
        self.is_open = False
        self.started: float | None = None
        self._index, self._time = 0, 0.0
        width = len(vehicle.channels)
        self._counters = [Counter(counter_law(encoder, vehicle)) for encoder in vehicle.encoders]
        self._bridges = Bridges(vehicle)
        self._absent = (math.nan,) * width
        self._nothing = (False,) * width
        self._waiting: set[int] = set()
        self._hoped: set[int] = set()
        self._awaited, self._doubtful = set(self.pdos), set[int]()
        self._held: set[int] = set()
        self._present = list(self._nothing)
        self._device_time, self._arrival_time = list(self._absent), list(self._absent)
        self._last_time: float | None = None
        self._open_gaps: dict[int, tuple[float, GapReason]] = {}
        self._jumped: set[int] = set()

    @property
    def is_complete(self) -> bool:
        """Whether every PDO has answered that used to do so."""
        return not self._waiting

    @property
    def is_settled(self) -> bool:
        """Whether nothing is hoped for either: PDOs that missed a SYNC lately, or a second frame.

        Waiting a little may bring them; waiting long for each would slow every sample down.
        """
        return not (self._held or self._hoped)

    def expect_length(self, cob_id: int, length: int) -> None:
        """Expect exactly so many bytes, after the mapping has been read from the device."""
        self.pdos[cob_id].length = length
        self.pdos[cob_id].exact = True

    def begin(self, index: int, time: float) -> None:
        """Open sample number `index` at the time of its SYNC [s]."""
        self._index, self._time, self.is_open = index, time, True
        if self.started is None:
            self.started = time
        self._waiting = self._awaited.copy()
        self._hoped = self._doubtful.copy()
        self._present[:] = self._nothing
        self._device_time[:] = self._absent
        self._arrival_time[:] = self._absent
        for pdo in self.pdos.values():
            pdo.answered = pdo.heard = False

    def frame(self, cob_id: int, data: bytes | bytearray, device_time: float, arrival_time: float) -> None:
        """Take a frame of a known PDO, at any time and of any content.

        Raises:
            KeyError: the COB-ID is none of `pdos`.
        """
        pdo = self.pdos[cob_id]
        length = len(data)
        if length != pdo.length and (pdo.exact or length < pdo.length):
            pdo.counts.wrong_length += 1
            pdo.heard = True
            self._waiting.discard(cob_id)
            self._hoped.discard(cob_id)
        elif pdo.answered:
            pdo.counts.duplicate += 1
        elif not self.is_open:
            self._late(pdo)
        elif pdo.owes and pdo.held is None:
            pdo.held = (int.from_bytes(data, "little"), device_time, arrival_time)
            pdo.heard = True
            self._held.add(cob_id)
            self._hoped.discard(cob_id)
        else:
            if pdo.held is not None:
                self._late(pdo)
            self._accept(pdo, int.from_bytes(data, "little"), device_time, arrival_time)

    def _late(self, pdo: Pdo) -> None:
        pdo.counts.late += 1
        pdo.counts.missing -= pdo.owes
        pdo.owes, pdo.held, pdo.heard = False, None, True
        self._held.discard(pdo.cob_id)
        self._doubt(pdo)

    def _accept(self, pdo: Pdo, word: int, device_time: float, arrival_time: float) -> None:
        pdo.answered = pdo.heard = True
        pdo.counts.received += 1
        self._waiting.discard(pdo.cob_id)
        self._hoped.discard(pdo.cob_id)
        for field in pdo.fields:
            column = field.column
            if self._counters[column].step(field.decode(word)):
                self._present[column] = True
                self._device_time[column] = device_time
                self._arrival_time[column] = arrival_time
            else:
                pdo.counts.jumps += 1
                self._jumped.add(column)

    def close(self) -> Sample:
        """Close the open sample and return it; frames that still come belong to no sample."""
        for cob_id in self._held:
            self._settle(self.pdos[cob_id])
        self._held.clear()
        self.is_open = False
        for pdo in self.pdos.values():
            if not pdo.answered:
                self._missed(pdo)
            elif pdo.cob_id in self._doubtful or pdo.misses:
                self._answers_again(pdo)
        present = tuple(self._present)
        self._bridges.follow(self._counters, self._present)
        self._follow_gaps(present)
        return Sample(
            self._index,
            self._time,
            tuple([counter.count or 0 for counter in self._counters]),
            present,
            tuple(self._device_time),
            tuple(self._arrival_time),
        )

    def restarted(self, node: int) -> None:
        """Note that a node has booted: its wheels' counters go on where they stood."""
        for column, encoder in enumerate(self.vehicle.encoders):
            if encoder.node == node:
                self._counters[column].rebase()
                start, _ = self._open_gaps.get(column, (self._last_good_time, "missing"))
                self._open_gaps[column] = (start, "reboot")
        self.await_again(node)

    def await_again(self, node: int) -> None:
        """Wait for a node's PDOs from the next SYNC on, owing nothing."""
        for pdo in self.pdos.values():
            if pdo.node == node:
                pdo.owes = False
                self._doubtful.discard(pdo.cob_id)
                self._awaited.add(pdo.cob_id)

    def skip(self, syncs: int) -> None:
        """Note that so many SYNCs could not be sent, in which the counters have gone on."""
        for _ in range(min(syncs, MAX_SKIP)):
            for counter in self._counters:
                counter.step(None)

    def _settle(self, pdo: Pdo) -> None:
        """Take the held frame for the answer to this SYNC: no second one has come."""
        held, pdo.held, pdo.owes = pdo.held, None, False
        if held is not None:
            self._accept(pdo, *held)

    def _missed(self, pdo: Pdo) -> None:
        for field in pdo.fields:
            self._counters[field.column].step(None)
        if not pdo.heard:
            pdo.counts.missing += 1
            pdo.owes = True
        pdo.misses += 1
        self._doubt(pdo)
        if pdo.misses >= SILENT_AFTER and not pdo.heard:
            self._doubtful.discard(pdo.cob_id)
        if pdo.misses == SILENT_AFTER:
            names = ", ".join(pdo.channels)
            self.events.add(self._time, pdo.node, f"{names}: no valid answer to SYNC")

    def _doubt(self, pdo: Pdo) -> None:
        """Hope for a PDO only, until it has answered many times in a row."""
        pdo.answers = 0
        self._awaited.discard(pdo.cob_id)
        self._doubtful.add(pdo.cob_id)

    def _answers_again(self, pdo: Pdo) -> None:
        self._doubtful.add(pdo.cob_id)
        pdo.answers += 1
        if pdo.answers >= TRUSTED_AFTER:
            self._doubtful.discard(pdo.cob_id)
            self._awaited.add(pdo.cob_id)
        if pdo.misses >= SILENT_AFTER:
            names = ", ".join(pdo.channels)
            self.events.add(self._time, pdo.node, f"{names}: answers SYNC again after {pdo.misses} without")
        pdo.misses = 0

    def gaps_until_now(self) -> tuple[Gap, ...]:
        """Return all gaps; one that is still open ends with the last sample."""
        still = [
            Gap(self.vehicle.channels[column], start, self._time, reason)
            for column, (start, reason) in sorted(self._open_gaps.items())
        ]
        return (*self.gaps, *still)

    @property
    def _last_good_time(self) -> float:
        return self._time if self._last_time is None else self._last_time

    def _follow_gaps(self, present: tuple[bool, ...]) -> None:
        if self._open_gaps or not all(present):
            for column, is_present in enumerate(present):
                self._follow_gap(column, is_present=is_present)
        self._jumped.clear()
        self._last_time = self._time

    def _follow_gap(self, column: int, *, is_present: bool) -> None:
        if not is_present and column not in self._open_gaps:
            reason: GapReason = "jump" if column in self._jumped else "missing"
            self._open_gaps[column] = (self._last_good_time, reason)
        elif is_present and column in self._open_gaps:
            start, reason = self._open_gaps.pop(column)
            if len(self.gaps) < MAX_GAPS:
                self.gaps.append(Gap(self.vehicle.channels[column], start, self._time, reason))
