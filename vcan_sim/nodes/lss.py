"""The LSS slave of a device (CiA 305): configuration of node id and bit rate, identification, fastscan."""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

MASTER, SLAVE = 0x7E5, 0x7E4  # COB-IDs
UNCONFIGURED = 0xFF  # node id of a device that has none
_BIT_RATES = {0, 1, 2, 3, 4, 6, 7}  # indices of the standard table: 1000 to 20 kbit/s
_IDENTITY = 4  # identity numbers: vendor, product, revision, serial


class Service(IntEnum):
    """The command specifiers of CiA 305."""

    SWITCH_GLOBAL = 0x04
    CONFIGURE_ID = 0x11
    CONFIGURE_BITS = 0x13
    STORE = 0x17
    SELECT_VENDOR = 0x40
    SELECT_SERIAL = 0x43
    SELECTED = 0x44
    IDENTIFY_VENDOR = 0x46
    IDENTIFY_SERIAL_HIGH = 0x4B
    IDENTIFY_UNCONFIGURED = 0x4C
    IDENTIFIED = 0x4F
    UNCONFIGURED_IDENTIFIED = 0x50
    FASTSCAN = 0x51
    INQUIRE_VENDOR = 0x5A
    INQUIRE_ID = 0x5E


class LssSlave:
    """The state of an LSS slave and its answers to the LSS master.

    The device uses the node id `active`, `pending` after a reset of the communication, and `stored` after
    power-on. `on_configured` is called when a device without node id leaves the configuration state with one.
    """

    def __init__(
        self,
        node: int,
        identity: Callable[[], tuple[int, ...]],
        send: Callable[[bytes], None],
        on_configured: Callable[[], None],
    ) -> None:
        self.active = self.pending = self.stored = node
        self._identity, self._send, self._on_configured = identity, send, on_configured
        self._configuring = False
        self._matched = 0  # identity numbers that have matched in this selection or identification
        self._position = 0  # identity number that fastscan scans now

    def receive(self, data: bytes) -> None:
        """Receive a message of the master; unknown or short ones are ignored."""
        if len(data) != 8:
            return
        command, value = data[0], int.from_bytes(data[1:5], "little")
        if command == Service.SWITCH_GLOBAL:
            self._switch(configuring=data[1] == 1)
        elif Service.SELECT_VENDOR <= command <= Service.SELECT_SERIAL:
            self._select(command - Service.SELECT_VENDOR, value)
        elif Service.IDENTIFY_VENDOR <= command <= Service.IDENTIFY_SERIAL_HIGH:
            self._identify(command - Service.IDENTIFY_VENDOR, value)
        elif command == Service.IDENTIFY_UNCONFIGURED and self.active == UNCONFIGURED:
            self._answer(Service.UNCONFIGURED_IDENTIFIED)
        elif command == Service.FASTSCAN and self.active == UNCONFIGURED and not self._configuring:
            self._fastscan(value, data[5], data[6], data[7])
        elif self._configuring:
            self._configure(command, data)

    def _switch(self, *, configuring: bool) -> None:
        leaves = self._configuring and not configuring
        self._configuring = configuring
        if leaves and self.active == UNCONFIGURED and self.pending != UNCONFIGURED:
            self._on_configured()

    def _select(self, number: int, value: int) -> None:
        """Compare one identity number; after four matches enter the configuration state."""
        if number == 0:
            self._matched = 0
        if self._matched == number and self._identity()[number] == value:
            self._matched += 1
        if number == _IDENTITY - 1 and self._matched == _IDENTITY:
            self._configuring = True
            self._answer(Service.SELECTED)

    def _identify(self, number: int, value: int) -> None:
        """Compare vendor, product, and the ranges of revision and serial number; answer if all fit."""
        vendor, product, revision, serial = self._identity()
        if number == 0:
            self._matched = 0
        fits = (
            value == vendor,
            value == product,
            value <= revision,
            value >= revision,
            value <= serial,
            value >= serial,
        )[number]
        self._matched += fits and self._matched == number
        if number == 5 and self._matched == 6:
            self._answer(Service.IDENTIFIED)

    def _fastscan(self, value: int, bit: int, number: int, following: int) -> None:
        """Answer if the upper bits of the scanned number are those of the identity (CiA 305 6.7)."""
        if bit == 0x80:
            self._position = 0
            self._answer(Service.IDENTIFIED)
            return
        if number != self._position or number >= _IDENTITY or bit > 31:
            return
        if self._identity()[number] >> bit != value >> bit:
            return
        self._answer(Service.IDENTIFIED)
        if bit == 0:
            self._position = following
            self._configuring = following < number

    def _configure(self, command: int, data: bytes) -> None:
        if command == Service.CONFIGURE_ID:
            is_right = 1 <= data[1] <= 127 or data[1] == UNCONFIGURED
            self.pending = data[1] if is_right else self.pending
            self._answer(command, 0 if is_right else 1)
        elif command == Service.CONFIGURE_BITS:
            self._answer(command, 0 if data[1] == 0 and data[2] in _BIT_RATES else 1)
        elif command == Service.STORE:
            self.stored = self.pending
            self._answer(command, 0)
        elif command == Service.INQUIRE_ID:
            self._answer(command, self.active)
        elif Service.INQUIRE_VENDOR <= command < Service.INQUIRE_ID:
            number = self._identity()[command - Service.INQUIRE_VENDOR]
            self._answer(command, *number.to_bytes(4, "little"))

    def _answer(self, command: int, *content: int) -> None:
        self._send(bytes([command, *content]).ljust(8, b"\0"))
