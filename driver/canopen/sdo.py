"""The objects of one node, read and written by SDO on a bus that no thread reads in the background."""

from __future__ import annotations

import threading
import time
from contextlib import contextmanager
from typing import TYPE_CHECKING, Literal

from canopen.objectdictionary.datatypes import INTEGER_TYPES
from canopen.sdo.client import SdoClient
from canopen.sdo.exceptions import SdoAbortedError, SdoCommunicationError

from omnimate.driver.canopen.dictionary import standard_dictionary
from omnimate.driver.errors import DriverError, NotTaken, SdoRefused, SdoSilent
from omnimate.files.logs.canopen_words import SDO_ANSWER, SDO_REQUEST

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from canopen import Network
    from canopen.objectdictionary import ObjectDictionary

TRIES = 3  # of a request that is not answered
MAX_RESPONSES = 64  # answers of one transfer, 7 bytes each: the driver reads no longer object
_STANDARD = standard_dictionary()  # for the sizes of objects that an EDS leaves out
# Command bytes of SDO and abort codes (CiA 301, 7.2.4).
UPLOAD, DOWNLOAD = 0x40, 0x23  # requests of an expedited transfer; the second with its size indicated
SEGMENTS = frozenset({0x00, 0x20})  # answers that name no object
UPLOADED, DOWNLOADED = 0x40, 0x60  # answers to the first request of an upload and of a download
LENGTH_WRONG = frozenset({0x06070010, 0x06070012, 0x06070013})
NO_OBJECT = bytes(3)  # index and sub-index in some devices' aborts


class Sdo(SdoClient):
    """The objects of one node as numbers, by canopen's SDO client.

    While it waits for an answer it reads the bus itself, in the thread that made it; in any other thread it
    waits until the first one reads the bus. A request without an answer is repeated twice. Late answers about
    another object, or to a download while the object is uploaded, are dropped; canopen takes them for the
    answer to its last request. Numbers are unsigned when read; negative ones are written as two's complement.
    """

    def __init__(
        self, node: int, dictionary: ObjectDictionary, network: Network, pump: Callable[[float], None]
    ) -> None:
        super().__init__(SDO_REQUEST + node, SDO_ANSWER + node, dictionary)  # type: ignore[no-untyped-call]  # canopen
        self.node = node  # CANopen node id of the server
        self.network = network
        self._pump = pump
        self._thread = threading.get_ident()
        self.max_responses = self._responses_left = MAX_RESPONSES  # answers accepted in one transfer
        self._object = b""  # index and sub-index of the current transfer as in a frame
        self._not_awaited = DOWNLOADED
        self.duplicate_answers = 0  # to requests that had been answered, since `reset_duplicate_answers`
        self._answered: set[bytes] = set()  # objects that were asked for once, and answered
        self._asked: set[bytes] = set()
        self._repeated: set[bytes] = set()
        self._written: list[tuple[int, int, int]] | None = None  # object and former value, while restoring

    @contextmanager
    def restoring(self) -> Iterator[None]:
        """Write former values back, the last first, where the block fails."""
        self._written = []
        try:
            yield
        except BaseException:
            self._restore(self._written)
            raise
        finally:
            self._written = None

    def answers(self) -> bool:
        """Ask once for the device type 1000h; return whether any answer comes."""
        try:
            self._transfer(0x1000, 0, None, tries=1)
        except SdoRefused:
            return True
        except SdoSilent:
            return False
        return True

    def read(self, index: int, subindex: int = 0) -> int:
        """Return an object as an unsigned number; raises SdoRefused or SdoSilent."""
        return int.from_bytes(self._transfer(index, subindex, None), "little")

    def read_bytes(self, index: int, subindex: int = 0) -> bytes:
        """Return all bytes of an object, in the size that the device gives it; errors as of `read`."""
        return self._transfer(index, subindex, None, whole=True)

    def write_bytes(self, index: int, subindex: int, data: bytes) -> None:
        """Write an object's bytes as they are; errors as of `write`."""
        self._transfer(index, subindex, data)

    def find(self, index: int, subindex: int = 0) -> int | None:
        """Return an object as an unsigned number, or None where the device refuses to show one.

        Devices have many abort codes for an object that they do not have, so that any of them means that.
        Raises SdoSilent.
        """
        try:
            return self.read(index, subindex)
        except SdoRefused:
            return None

    def write(self, index: int, subindex: int, value: int) -> None:
        """Write an object in its standard size, or in the size of the device's object where that differs.

        Raises SdoRefused or SdoSilent.
        """
        before = None if self._written is None else self.find(index, subindex)
        self._write(index, subindex, value, before)

    def put(self, index: int, subindex: int, value: int) -> bool:
        """Write an object that has another value, and read it back if it can be; return whether it had.

        Raises NotTaken, SdoRefused or SdoSilent.
        """
        wanted = value % (1 << 8 * self._size(index, subindex))
        before = self.find(index, subindex)
        if before == wanted:
            return False
        self._write(index, subindex, value, before)
        reads = self.find(index, subindex)
        if reads not in {wanted, None}:
            raise NotTaken(self.node, index, subindex, wanted, reads)
        return True

    def ask(self, index: int, subindex: int = 0) -> None:
        """Request an object without waiting; the answer goes to the monitor of the bus; raises BusLost."""
        self._request(UPLOAD, index, subindex, b"")

    def post(self, index: int, subindex: int, value: int) -> None:
        """Write an object in its standard size without waiting for the confirmation; raises BusLost."""
        size = self._size(index, subindex)
        self._request(DOWNLOAD | (4 - size) << 2, index, subindex, _pack(value, size))

    def reset_duplicate_answers(self) -> None:
        """Count duplicate answers from zero; requests that are repeated from now on may have two."""
        self.duplicate_answers = 0
        for objects in (self._asked, self._answered, self._repeated):
            objects.clear()

    def on_response(self, can_id: int, data: bytes | bytearray, timestamp: float) -> None:
        """Take an answer of 8 bytes, unless it is a late one about another request."""
        kind, about = data[0] & 0xE0, bytes(data[1:4])
        if kind not in SEGMENTS and about in self._answered - self._repeated:
            self.duplicate_answers += 1
        elif about == self._object:
            self._answered.add(about)
        if kind in SEGMENTS or (kind != self._not_awaited and about in {self._object, NO_OBJECT}):
            super().on_response(can_id, data, timestamp)  # type: ignore[no-untyped-call]  # canopen

    def read_response(self) -> bytes:
        """Return the next answer; canopen calls this, and takes SdoAbortedError or SdoCommunicationError."""
        self._responses_left -= 1
        if self._responses_left < 0:
            raise SdoCommunicationError("the answer does not end")
        if threading.get_ident() == self._thread:
            end = time.monotonic() + self.RESPONSE_TIMEOUT
            while self.responses.empty():
                left = end - time.monotonic()
                self._pump(max(0.0, left))
                if left <= 0.0 and self.responses.empty():
                    raise SdoCommunicationError("no answer")
        return super().read_response()  # type: ignore[no-any-return, no-untyped-call]  # canopen

    def _write(self, index: int, subindex: int, value: int, before: int | None) -> None:
        size = self._size(index, subindex)
        try:
            self._transfer(index, subindex, _pack(value, size))
        except SdoRefused as refused:
            if refused.abort_code not in LENGTH_WRONG:
                raise
            size = len(self._transfer(index, subindex, None, whole=True))
            self._transfer(index, subindex, _pack(value, size))
        if self._written is not None and before is not None:
            self._written.append((index, subindex, before))

    def _restore(self, written: list[tuple[int, int, int]]) -> None:
        """Write former values back; a value that is refused is skipped, silence ends it."""
        self._written = None
        for index, subindex, before in reversed(written):
            try:
                self.write(index, subindex, before)
            except SdoRefused:
                continue
            except DriverError:
                return

    def _size(self, index: int, subindex: int) -> int:
        variable = self.od.get_variable(index, subindex) or _STANDARD.get_variable(index, subindex)
        return len(variable) // 8 if variable is not None and variable.data_type in INTEGER_TYPES else 4

    def _request(self, command: int, index: int, subindex: int, data: bytes) -> None:
        """Send a request of an expedited transfer (CiA 301)."""
        self.network.send_message(
            self.rx_cobid, bytes((command,)) + _place(index, subindex) + data.ljust(4, b"\0")
        )

    def _transfer(
        self, index: int, subindex: int, data: bytes | None, *, whole: bool = False, tries: int = TRIES
    ) -> bytes:
        for left in reversed(range(tries)):
            self._begin(_place(index, subindex), is_write=data is not None)
            try:
                if data is not None:
                    self.download(index, subindex, data)
                    return b""
                if whole:
                    with self.open(index, subindex, buffering=0) as stream:  # type: ignore[no-untyped-call]
                        return bytes(stream.read())
                return bytes(self.upload(index, subindex))
            except SdoAbortedError as aborted:
                access: Literal["read", "write"] = "read" if data is None else "write"
                raise SdoRefused(self.node, index, subindex, aborted.code, access) from aborted
            except SdoCommunicationError as error:
                if not left:
                    raise SdoSilent(self.node, index, subindex, str(error)) from error
        raise AssertionError  # the loop returns or raises

    def _begin(self, place: bytes, *, is_write: bool) -> None:
        """Expect answers about one object from now on, at most `max_responses`."""
        self._responses_left = self.max_responses
        self._object = place
        self._not_awaited = UPLOADED if is_write else DOWNLOADED
        if place in self._asked:
            self._repeated.add(place)
        self._asked.add(place)


def _place(index: int, subindex: int) -> bytes:
    return index.to_bytes(2, "little") + bytes((subindex,))


def _pack(value: int, size: int) -> bytes:
    return (value % (1 << 8 * size)).to_bytes(size, "little")
