"""The transmitter of a device, with its faults: silence, wrong lengths, late answers, babbling."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

_NO_PDO = 0x7FF  # COB-ID used by a device that babbles before it has sent a PDO


@dataclass(frozen=True, slots=True)
class Babble:
    """Frames with which a device floods the bus."""

    frames: int  # number of frames in one burst
    every: float  # time between two bursts [s]
    cob_id: int | None  # COB-ID of the frames; None for the device's own first TPDO
    data: bytes | None  # data of the frames; None for the last data of that TPDO


@dataclass(frozen=True, slots=True)
class Disturbance:
    """The faults of a device."""

    off: bool = False  # whether the device is without power: it neither receives nor sends
    silent: bool = False  # whether the device sends nothing
    frozen: bool = False  # whether the device's PDOs repeat their last data
    # length that the device's PDOs are cut or filled up to [byte]; None for the length of their mapping
    length: int | None = None
    late_by: float = 0.0  # delay of late PDOs [s]
    late_every: int = 1  # one of this number of PDOs is late
    babble: Babble | None = None  # frames with which the device floods the bus; None for none


NONE = Disturbance()


class Transmitter:
    """Sends the frames of a device, changed by its faults; delayed frames or a burst are `due` [s]."""

    def __init__(self, send: Callable[[int, bytes], None]) -> None:
        self._send = send
        self.disturbance = NONE  # the current faults; `disturb` changes them
        self._held: list[tuple[float, int, bytes]] = []
        self._burst_due = math.inf
        self._answers = 0
        self._last: dict[int, bytes] = {}
        self.due = math.inf

    def disturb(self, disturbance: Disturbance, now: float) -> None:
        """Change the faults."""
        starts = disturbance.babble is not self.disturbance.babble
        self.disturbance = disturbance
        if starts:
            self._burst_due = now if disturbance.babble else math.inf
        self._reschedule()

    def send(self, cob_id: int, data: bytes) -> None:
        """Send a frame that is no PDO."""
        if not (self.disturbance.silent or self.disturbance.off):
            self._send(cob_id, data)

    def send_pdo(self, cob_id: int, data: bytes, now: float) -> None:
        """Send a PDO."""
        if self.disturbance is NONE:
            self._last[cob_id] = data
            self._send(cob_id, data)
        else:
            self._send_disturbed(cob_id, data, now)

    def _send_disturbed(self, cob_id: int, data: bytes, now: float) -> None:
        self._send_held(now)
        wrong = self.disturbance
        if wrong.frozen:
            data = self._last.get(cob_id, data)
        self._last[cob_id] = data
        if wrong.length is not None:
            data = data[: wrong.length].ljust(wrong.length, b"\0")
        self._answers += 1
        if wrong.late_by > 0.0 and self._answers % wrong.late_every == 0:
            self._held.append((now + wrong.late_by, cob_id, data))
            self._reschedule()
        else:
            self.send(cob_id, data)

    def run(self, now: float) -> None:
        """Send delayed frames and bursts whose time has passed [s]."""
        self._send_held(now)
        babble = self.disturbance.babble
        if babble is not None and now >= self._burst_due:
            self._burst_due = max(self._burst_due + babble.every, now)
            cob_id, data = self._babble_frame()
            for _ in range(babble.frames):
                self.send(cob_id, data)
        self._reschedule()

    def _send_held(self, now: float) -> None:
        ready = [frame for frame in self._held if frame[0] <= now]
        self._held = [frame for frame in self._held if frame[0] > now]
        for _, cob_id, data in ready:
            self.send(cob_id, data)

    def _babble_frame(self) -> tuple[int, bytes]:
        """Return COB-ID and data of a babbling device; by default those of its first PDO."""
        babble = self.disturbance.babble
        assert babble is not None  # checked by the caller
        cob_id = babble.cob_id
        if cob_id is None:
            cob_id = next(iter(self._last), _NO_PDO)
        return cob_id, babble.data if babble.data is not None else self._last.get(cob_id, b"\xff" * 8)

    def _reschedule(self) -> None:
        self.due = min((frame[0] for frame in self._held), default=math.inf)
        self.due = min(self.due, self._burst_due)
