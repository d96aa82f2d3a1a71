"""PDOs to samples, live: the steps of `omnimate.vehicle.assembly`, and which PDOs are worth waiting for.

This file uses no bus and no clock.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.driver.robot.events import EventLog, NodeCounts
from omnimate.vehicle.assembly import (
    ACCEPTED,
    HELD,
    LATE,
    REASONS,
    WRONG_LENGTH,
    assembly_records,
    close_sample,
    open_sample,
    take_boot,
    take_frame,
    take_start,
)
from omnimate.vehicle.recording import Gap
from omnimate.vehicle.sample import Sample

if TYPE_CHECKING:
    from omnimate.vehicle.parameters import Channel, VehicleParameters

# Limits of the driver; no standard states them.
TRUSTED_AFTER = 100  # SYNCs in a row with an answer, after a miss, before it is waited for at length again
SILENT_TIME = 2.0  # [s] without an answer after which a node is configured again; a boot takes less
SILENT_AFTER = 3  # SYNCs in a row without an answer, before it is called silence and not waited for
MAX_GAPS = 10_000
_COUNTED = ("received", "missing", "late", "duplicate", "jumps")  # of `NodeCounts`, by the records of PDOs


@dataclass(slots=True)
class _Pdo:
    """One TPDO as it is waited for."""

    place: int  # place of its record
    node: int  # node that sends the PDO
    channels: tuple[Channel, ...]  # channels that the PDO carries
    misses: int = 0  # SYNCs in a row without an answer
    answers: int = 0  # SYNCs in a row with an answer, since the last miss


class Assembler:
    """The state between two SYNCs: which PDOs have answered, and the position of each counter.

    `counts` are as of the last sample or `update_counts`; `gaps` have ended, at most `MAX_GAPS`; `started` is
    the time of the first SYNC [s].
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
        self.gaps: list[Gap] = []
        self.started: float | None = None
        _compile_steps(vehicle)
        self._state = self._cycle, self._pdos, self._channels = assembly_records(vehicle)
        self._expected = {
            cob_id: _Pdo(
                place,
                int(self._pdos["node"][place]),
                tuple(encoder.channel for encoder in vehicle.encoders if encoder.cob_id == cob_id),
            )
            for place, cob_id in enumerate(self._pdos["cob_id"].tolist())
        }
        self.cob_ids = self._expected.keys()
        self._index = 0
        self._silent: set[int] = set()
        self._long = max(SILENT_AFTER, math.ceil(SILENT_TIME / vehicle.bus.sync_period))  # SYNCs
        # COB-IDs: PDOs that answer reliably are waited for at length, unreliable ones only for a short time.
        self._reliable, self._unreliable = set(self.cob_ids), set[int]()
        self._waiting: set[int] = set()
        self._waiting_shortly: set[int] = set()
        self._held: set[int] = set()

    @property
    def is_open(self) -> bool:
        """Whether a SYNC has been sent and its sample is not closed."""
        return bool(self._cycle["is_open"][0])

    @property
    def is_synchronous(self) -> bool:
        """Whether PDOs answer SYNC; otherwise each is current when it comes, and none is late."""
        return bool(self._cycle["is_synchronous"][0])

    @is_synchronous.setter
    def is_synchronous(self, value: bool) -> None:
        self._cycle["is_synchronous"] = value

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
        pdo = self._pdos[self._expected[cob_id].place]
        pdo["length"], pdo["is_mapped"], pdo["is_exact"], pdo["is_timed"] = length, True, False, is_timed

    def begin(self, index: int, time: float) -> None:
        """Open sample `index` with SYNC at `time` [s]; SYNCs left out since the last one count as missed."""
        open_sample(*self._state, time)
        self._index = index
        if self.started is None:
            self.started = time
        self._waiting = self._reliable.copy()
        # where all are silent, nothing else shows that the answers to this SYNC are over
        is_awaited = self._reliable or self._unreliable
        self._waiting_shortly = self._unreliable.copy() if is_awaited else set(self.cob_ids)

    def frame(self, cob_id: int, data: bytes | bytearray, device_time: float, arrival_time: float) -> None:
        """Take a frame of an expected PDO, at any time and of any content.

        Args:
            cob_id: COB-ID of the frame.
            data: Data bytes of the frame.
            device_time: Timestamp of the adapter [s].
            arrival_time: When the frame was on the bus, on the recording's clock [s].

        Raises:
            KeyError: The COB-ID is not in `cob_ids`.
        """
        pdo = self._expected[cob_id]
        word = np.uint64(int.from_bytes(data[:8], "little"))
        outcome = take_frame(self._cycle, self._pdos, pdo.place, word, len(data), device_time, arrival_time)
        if outcome in {ACCEPTED, HELD, WRONG_LENGTH}:
            self._waiting_shortly.discard(cob_id)
        if outcome in {ACCEPTED, WRONG_LENGTH}:
            self._waiting.discard(cob_id)
        if outcome == WRONG_LENGTH:
            self.counts[pdo.node].wrong_length += 1
        elif outcome == HELD:
            self._held.add(cob_id)
        elif outcome == LATE or (outcome == ACCEPTED and cob_id in self._held):
            self._held.discard(cob_id)
            self._mark_unreliable(cob_id)
            self._waiting_shortly.discard(cob_id)
        state = self._pdos[pdo.place]
        if len(data) > state["length"] and state["is_mapped"] and not state["is_exact"]:
            taken = f"its mapping {state['length']}: the first are taken"
            self.events.add(arrival_time, pdo.node, f"PDO {cob_id:03X}h has {len(data)} bytes and {taken}")

    def close(self) -> Sample:
        """Close the open sample and return it; frames that still come belong to no sample."""
        close_sample(*self._state)
        self._held.clear()
        states = self._pdos[["answered", "heard", "is_boot_doubted"]].tolist()
        self._pdos["is_boot_doubted"] = False
        for (cob_id, pdo), (answered, heard, doubted) in zip(self._expected.items(), states, strict=True):
            if doubted:
                self._add_event(pdo, "its boot-up is not believed: its PDOs did not stop")
            if not answered:
                self._missed(cob_id, pdo, heard=heard)
            elif cob_id in self._unreliable or pdo.misses:
                self._answers_again(cob_id, pdo)
        for column in np.flatnonzero(self._channels["ended_gap"]).tolist():
            if len(self.gaps) < MAX_GAPS:
                channel = self._channels[column]
                self.gaps.append(self._gap(column, channel["gap_start"], channel["ended_gap"]))
        self.update_counts()
        present = self._channels["present"]
        places = self._channels["pdo"]
        device_time, arrival_time = (
            np.where(present, self._pdos[name][places], math.nan) for name in ("device_time", "arrival_time")
        )
        return Sample(
            self._index,
            float(self._cycle["time"][0]),
            tuple(self._channels["count"].tolist()),
            tuple(present.tolist()),
            tuple(device_time.tolist()),
            tuple(arrival_time.tolist()),
        )

    def node_booted(self, node: int) -> None:
        """Note a boot-up of a node, which its PDOs have to confirm."""
        take_boot(self._pdos, node)

    def node_started(self, node: int) -> None:
        """Note that a node, 0 for all, was started, and its PDOs are waited for again."""
        take_start(self._pdos, node)
        for cob_id, pdo in self._expected.items():
            if node in {0, pdo.node}:
                self._unreliable.discard(cob_id)
                self._reliable.add(cob_id)

    def is_answering(self, node: int) -> bool:
        """Return whether all PDOs of a node answered the last SYNC."""
        return not any(pdo.misses for pdo in self._expected.values() if pdo.node == node)

    def silence(self, node: int) -> float:
        """Return for how long the most silent PDO of a node has not answered [s]."""
        misses = max(pdo.misses for pdo in self._expected.values() if pdo.node == node)
        return misses * self.vehicle.bus.sync_period

    def never_answered(self, node: int) -> bool:
        """Return whether a PDO of a node has not entered any sample."""
        return bool((self._pdos["last"][self._pdos["node"] == node] < 0).any())

    def is_late(self, node: int) -> bool:
        """Return whether an answer of a node has come after its sample was closed."""
        return bool(self._pdos["late"][self._pdos["node"] == node].any())

    def take_silent(self) -> set[int]:
        """Return the nodes that have not answered for `SILENT_TIME` since they were last returned."""
        silent, self._silent = self._silent, set()
        return silent

    def gaps_until_now(self) -> tuple[Gap, ...]:
        """Return all gaps; one that is still open ends with the last sample."""
        still = [
            self._gap(column, self._channels["last_good"][column], self._channels["gap"][column])
            for column in np.flatnonzero(self._channels["gap"]).tolist()
        ]
        return (*self.gaps, *still)

    def update_counts(self) -> None:
        """Write into `counts` what has become of the PDOs."""
        totals: dict[int, list[int]] = {}
        for node, *numbers in self._pdos[["node", *_COUNTED]].tolist():
            totals[node] = [a + b for a, b in zip(totals.get(node, [0] * len(numbers)), numbers, strict=True)]
        for node, numbers in totals.items():
            for name, number in zip(_COUNTED, numbers, strict=True):
                setattr(self.counts[node], name, number)

    def _gap(self, column: int, start: float, reason: int) -> Gap:
        end = float(self._cycle["time"][0])
        return Gap(self.vehicle.channels[column], float(start), end, REASONS[reason])

    def _missed(self, cob_id: int, pdo: _Pdo, *, heard: bool) -> None:
        pdo.misses += 1
        self._mark_unreliable(cob_id)
        if pdo.misses >= SILENT_AFTER and not heard:
            self._unreliable.discard(cob_id)
        if not self.is_synchronous:
            return
        if pdo.misses == SILENT_AFTER:
            self._add_event(pdo, f"{', '.join(pdo.channels)}: no valid answer to SYNC")
        if pdo.misses % self._long == 0:
            self._silent.add(pdo.node)

    def _mark_unreliable(self, cob_id: int) -> None:
        """Wait for a PDO only for a short time, until it has answered many times in a row."""
        self._expected[cob_id].answers = 0
        self._reliable.discard(cob_id)
        self._unreliable.add(cob_id)

    def _answers_again(self, cob_id: int, pdo: _Pdo) -> None:
        self._unreliable.add(cob_id)
        pdo.answers += 1
        if pdo.answers >= TRUSTED_AFTER:
            self._unreliable.discard(cob_id)
            self._reliable.add(cob_id)
        if pdo.misses >= SILENT_AFTER and self.is_synchronous:
            names = ", ".join(pdo.channels)
            self._add_event(pdo, f"{names}: answers SYNC again after {pdo.misses} without")
        pdo.misses = 0

    def _add_event(self, pdo: _Pdo, what: str) -> None:
        self.events.add(float(self._cycle["time"][0]), pdo.node, what)


def _compile_steps(vehicle: VehicleParameters) -> None:
    """Compile the steps, which may take seconds, before the first SYNC."""
    cycles, pdos, channels = assembly_records(vehicle)
    open_sample(cycles, pdos, channels, 0.0)
    take_frame(cycles, pdos, 0, np.uint64(0), 8, 0.0, 0.0)
    close_sample(cycles, pdos, channels)
    take_boot(pdos, 1)
    take_start(pdos, 1)
