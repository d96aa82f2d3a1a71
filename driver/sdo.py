"""SDO to one node: numbers in, numbers out, refusals in words, and no wait without an end."""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING

from canopen.objectdictionary.datatypes import INTEGER_TYPES
from canopen.sdo.client import SdoClient
from canopen.sdo.exceptions import SdoAbortedError, SdoCommunicationError

from driver.errors import NotTaken, SdoRefused, SdoSilent

if TYPE_CHECKING:
    from collections.abc import Callable

    from canopen import Network
    from canopen.objectdictionary import ObjectDictionary

TRIES = 3
MAX_RESPONSES = 64  # of one transfer: no object that is read here is longer
SEGMENTS = frozenset({0x00, 0x20})  # answers that name no object
NO_OBJECT = bytes(3)  # in some devices' aborts
OBJECT_ABSENT = frozenset({0x06010000, 0x06010001, 0x06020000, 0x06090011, 0x08000024, 0x060A0023})
LENGTH_WRONG = frozenset({0x06070010, 0x06070012, 0x06070013})


class PumpedSdoClient(SdoClient):
    """canopen's client on a bus that nobody reads in the background.

    In the thread that made it, it reads the bus itself while it waits; in any other thread it waits until the
    bus is read there. canopen itself takes any answer for the one to its last request.
    """

    def __init__(
        self, node: int, dictionary: ObjectDictionary, network: Network, pump: Callable[[float], None]
    ) -> None:
        super().__init__(0x600 + node, 0x580 + node, dictionary)  # type: ignore[no-untyped-call]  # canopen
        self.network = network
        self._pump = pump
        self._thread = threading.get_ident()
        self.responses_left = MAX_RESPONSES
        self.object = b""

    def on_response(self, can_id: int, data: bytes | bytearray, timestamp: float) -> None:
        """Take an answer, unless it is a late one about another object."""
        about = bytes(data[1:4])
        if data[0] & 0xE0 in SEGMENTS or about in {self.object, NO_OBJECT}:
            super().on_response(can_id, data, timestamp)  # type: ignore[no-untyped-call]  # canopen

    def read_response(self) -> bytes:
        """Return the next answer.

        Raises:
            SdoAbortedError: the node refuses.
            SdoCommunicationError: it does not answer in time, or does not stop answering.
        """
        self.responses_left -= 1
        if self.responses_left < 0:
            raise SdoCommunicationError("the answer does not end")
        if threading.get_ident() == self._thread:
            end = time.monotonic() + self.RESPONSE_TIMEOUT
            while self.responses.empty():
                left = end - time.monotonic()
                self._pump(max(0.0, left))
                if left <= 0.0 and self.responses.empty():
                    raise SdoCommunicationError("no answer")
        return super().read_response()  # type: ignore[no-any-return, no-untyped-call]  # canopen


class Sdo:
    """The objects of one node."""

    def __init__(self, node: int, client: PumpedSdoClient) -> None:
        self.node = node
        self.client = client

    def read(self, index: int, subindex: int = 0) -> int:
        """Return an object as an unsigned number.

        Raises:
            SdoRefused: the node aborts.
            SdoSilent: it does not answer.
        """
        return int.from_bytes(self._transfer(index, subindex, None), "little")

    def find(self, index: int, subindex: int = 0) -> int | None:
        """Return an object as an unsigned number, or None where the device has no such object.

        Raises:
            SdoRefused: for any other reason.
            SdoSilent: as `read`.
        """
        try:
            return self.read(index, subindex)
        except SdoRefused as refused:
            if refused.abort_code in OBJECT_ABSENT:
                return None
            raise

    def write(self, index: int, subindex: int, value: int) -> None:
        """Write an object in its standard size, or in the device's own where that differs.

        Raises:
            SdoRefused, SdoSilent: as `read`.
        """
        size = self._size(index, subindex)
        try:
            self._transfer(index, subindex, _pack(value, size))
        except SdoRefused as refused:
            if refused.abort_code not in LENGTH_WRONG:
                raise
            size = len(self._transfer(index, subindex, None, whole=True))
            self._transfer(index, subindex, _pack(value, size))

    def put(self, index: int, subindex: int, value: int) -> None:
        """Write an object and read it back.

        Raises:
            NotTaken: the device confirmed and kept another value.
            SdoRefused, SdoSilent: as `read`.
        """
        self.write(index, subindex, value)
        reads = self.read(index, subindex)
        wrote = value % (1 << 8 * self._size(index, subindex))
        if reads != wrote:
            raise NotTaken(self.node, index, subindex, wrote, reads)

    def _size(self, index: int, subindex: int) -> int:
        variable = self.client.od.get_variable(index, subindex)
        return len(variable) // 8 if variable is not None and variable.data_type in INTEGER_TYPES else 4

    def _transfer(self, index: int, subindex: int, data: bytes | None, *, whole: bool = False) -> bytes:
        for left in reversed(range(TRIES)):
            self.client.responses_left = MAX_RESPONSES
            self.client.object = index.to_bytes(2, "little") + bytes((subindex,))
            try:
                if data is not None:
                    self.client.download(index, subindex, data)
                    return b""
                if whole:
                    with self.client.open(index, subindex, buffering=0) as stream:  # type: ignore[no-untyped-call]
                        return bytes(stream.read())
                return bytes(self.client.upload(index, subindex))
            except SdoAbortedError as aborted:
                raise SdoRefused(self.node, index, subindex, aborted.code) from aborted
            except SdoCommunicationError as error:
                if not left:
                    raise SdoSilent(self.node, index, subindex, str(error)) from error
        raise AssertionError  # the loop returns or raises


def _pack(value: int, size: int) -> bytes:
    return (value % (1 << 8 * size)).to_bytes(size, "little")
