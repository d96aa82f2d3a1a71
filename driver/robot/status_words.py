"""Monitors the status word 6041h of every enabled drive, by TPDO where one brings it in time, else by SDO."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.driver.canopen.cia402 import ENABLED, FAULT, FAULT_MASK, STATE_MASK
from omnimate.driver.canopen.pdo_mapping import Entry, placed
from omnimate.driver.robot.events import Trouble

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from omnimate.driver.canopen.pdo_parameters import PdoSetting
    from omnimate.driver.robot.events import EventLog

STATUS_WORD = Entry(0x6041, 0, 16)
# A lost drive must stop the robot within 100 ms: 30 ms until the next request and 60 ms for its answer.
STATUS_AGE = 0.03  # [s] after which a status word that no TPDO brings is asked for again
UNANSWERED = 0.06  # [s] without an answer, after which a drive counts as silent
PATIENCE = 3.0  # times the answer time at enabling: the limit for a drive that answers slowly
BY_EVENT = 254  # transmission types from here on are sent at every change (CiA 301, 7.5.2.37)
ACYCLIC = 0  # transmission type: sent with the next SYNC after a change
UPLOAD_ANSWER = 0x40  # SDO command specifier of the server (CiA 301, 7.2.4)
LONGEST_INHIBIT = 200  # [100 us] between two status words, so that a fault shows within 20 ms


@dataclass(frozen=True, slots=True)
class StatusSource:
    """How the status word of one drive reaches the driver."""

    node: int  # CANopen node id
    # COB-ID of each TPDO that carries the status word, and the first bit of it
    fields: tuple[tuple[int, int], ...]
    is_timely: bool  # whether one of them brings every change within `STATUS_AGE`


def status_source(node: int, settings: Iterable[PdoSetting], sync_period: float | None) -> StatusSource:
    """Return the TPDOs of a drive that carry the status word, and whether they bring it in time.

    Without a SYNC period [s], no heartbeat shows that the drive is there: its word is asked for in any case.
    """
    fields: list[tuple[int, int]] = []
    is_timely = False
    for setting in settings:
        for bit, entry in placed(setting.entries):
            if entry == STATUS_WORD and setting.is_valid and not setting.is_extended:
                fields.append((setting.cob_id, bit))
                is_timely |= sync_period is not None and _is_timely(setting, sync_period)
    return StatusSource(node, tuple(fields), is_timely)


def _is_timely(setting: PdoSetting, sync_period: float) -> bool:
    if setting.transmission >= BY_EVENT:
        return (setting.inhibit or 0) <= LONGEST_INHIBIT
    return setting.transmission == ACYCLIC or setting.transmission * sync_period <= STATUS_AGE


@dataclass(slots=True)
class _MonitoredDrive:
    """One drive: when its status word was seen, since when a request is unanswered, how long it may be."""

    source: StatusSource
    seen: float
    patience: float
    asked: float | None = None
    sent: float = 0.0
    is_cut: bool = False  # whether the last TPDO that should carry the word was too short for it


class StatusWordMonitor:
    """The status words of all drives, from the moment when they are enabled until they are stopped.

    `fields` has node and first bit of the status word in the TPDOs that carry one, by COB-ID.
    """

    def __init__(self, troubles: list[Trouble], events: EventLog) -> None:
        self.fields: dict[int, list[tuple[int, int]]] = {}
        self._troubles, self._events = troubles, events
        self._drives: dict[int, _MonitoredDrive] = {}
        self._ask: Callable[[int], None] = lambda _node: None

    def expect(self, source: StatusSource) -> None:
        """Take the status word of a drive from now on, which need not be enabled."""
        for cob_id, bit in source.fields:
            others = [field for field in self.fields.get(cob_id, []) if field[0] != source.node]
            self.fields[cob_id] = [*others, (source.node, bit)]

    def begin(self, answered: Mapping[StatusSource, float], ask: Callable[[int], None], now: float) -> None:
        """Monitor drives that are enabled at `now` [s]; raises BusLost.

        `answered` has the time that each took to answer for 6041h [s]; `ask` requests it without waiting.
        """
        self._ask = ask
        self._drives = {}
        for source, answer in answered.items():
            patience = max(UNANSWERED, PATIENCE * answer)
            self._drives[source.node] = drive = _MonitoredDrive(source, now, patience)
            self._request(drive, now)
            if patience > UNANSWERED and not source.is_timely:
                what = f"answers for 6041h after {answer:.2g} s: a fault shows late; map 6041h into a TPDO"
                self._events.add(now, source.node, what)

    def end(self) -> None:
        """Stop monitoring: the drives are stopped."""
        self._drives = {}

    def pdo(self, cob_id: int, data: bytes | bytearray, now: float) -> bool:
        """Take a TPDO of `fields` at time `now` [s]; return False where it is too short.

        A drive that sends such a one is asked by SDO.
        """
        word = int.from_bytes(data, "little")
        is_whole = True
        for node, bit in self.fields[cob_id]:
            is_cut = bit + STATUS_WORD.bits > 8 * len(data)
            is_whole &= not is_cut
            if node in self._drives:
                self._drives[node].is_cut = is_cut
            if not is_cut:
                self._status(node, word >> bit & 0xFFFF, now)
        return is_whole

    def sdo_answer(self, node: int, data: bytes | bytearray, now: float) -> None:
        """Take an SDO answer of 8 bytes at time `now` [s]; those about other objects are ignored."""
        if data[0] & 0xE0 == UPLOAD_ANSWER and bytes(data[1:4]) == b"\x41\x60\x00":
            self._status(node, int.from_bytes(data[4:6], "little"), now)

    def check(self, now: float) -> None:
        """Ask for the status words that are due at time `now` [s], and report drives that do not answer.

        Raises BusLost.
        """
        for drive in tuple(self._drives.values()):
            if drive.asked is None:
                is_timely = drive.source.is_timely and not drive.is_cut
                if not is_timely and now - drive.seen >= STATUS_AGE:
                    self._request(drive, now)
            elif now - drive.asked >= drive.patience:
                self._report(drive, now, f"no answer for its status word 6041h within {drive.patience:.2g} s")
            elif now - drive.sent >= drive.patience / 2.0:
                drive.sent = now
                self._ask(drive.source.node)

    def pause(self, now: float) -> None:
        """Exclude a time until `now` [s], in which the bus was not read, from the silence: ask again."""
        for drive in self._drives.values():
            drive.seen, drive.asked = now - STATUS_AGE, None

    def _request(self, drive: _MonitoredDrive, now: float) -> None:
        drive.asked = drive.sent = now
        self._ask(drive.source.node)

    def _status(self, node: int, status: int, now: float) -> None:
        drive = self._drives.get(node)
        if drive is None:
            return
        drive.seen, drive.asked = now, None
        if status & STATE_MASK == ENABLED:
            return
        what = "reports a fault" if status & FAULT_MASK == FAULT else "has left operation enabled"
        self._report(drive, now, f"the drive {what} (status word {status:04X}h)", status)

    def _report(self, drive: _MonitoredDrive, now: float, what: str, status: int | None = None) -> None:
        """Report a drive once: it is not monitored any longer."""
        del self._drives[drive.source.node]
        self._events.add(now, drive.source.node, what)
        self._troubles.append(Trouble(now, drive.source.node, what, status=status))
