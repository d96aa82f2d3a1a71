"""The objects of one node as numbers, read and written by SDO."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, Literal

from canopen.objectdictionary.datatypes import INTEGER_TYPES
from canopen.sdo.exceptions import SdoAbortedError, SdoCommunicationError

from omnimate.driver.canopen.dictionary import standard_dictionary
from omnimate.driver.errors import DriverError, NotTaken, SdoRefused, SdoSilent

if TYPE_CHECKING:
    from collections.abc import Iterator

    from omnimate.driver.canopen.sdo_client import PumpedSdoClient

TRIES = 3
UPLOAD, DOWNLOAD = 0x40, 0x23  # requests of an expedited transfer; the second with its size indicated
_STANDARD = standard_dictionary()  # for the sizes of objects that an EDS leaves out
# SDO abort codes, CiA 301
LENGTH_WRONG = frozenset({0x06070010, 0x06070012, 0x06070013})


class Sdo:
    """The objects of one node.

    A request without an answer is repeated twice. Numbers are unsigned when read; negative ones are written
    as two's complement.

    Args:
        node: CANopen node id.
        client: SDO client for this node.

    Attributes:
        node: CANopen node id.
        client: SDO client for this node.
    """

    def __init__(self, node: int, client: PumpedSdoClient) -> None:
        self.node = node
        self.client = client
        self._written: list[tuple[int, int, int]] | None = None  # object and former value, while restoring

    @contextmanager
    def restoring(self) -> Iterator[None]:
        """Put everything that is written inside this block back, the last first, where the block fails."""
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
        """Return an object as an unsigned number.

        Raises:
            SdoRefused: The node aborts the transfer.
            SdoSilent: The node does not answer.
        """
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

        Raises:
            SdoSilent: The node does not answer.
        """
        try:
            return self.read(index, subindex)
        except SdoRefused:
            return None

    def write(self, index: int, subindex: int, value: int) -> None:
        """Write an object in its standard size, or in the size of the device's object where that differs.

        Raises:
            SdoRefused: The node aborts the transfer.
            SdoSilent: The node does not answer.
        """
        before = None if self._written is None else self.find(index, subindex)
        self._write(index, subindex, value, before)

    def put(self, index: int, subindex: int, value: int) -> bool:
        """Have an object hold a value: write it where it holds another one, and read it back where it can.

        Returns:
            Whether it held another value before.

        Raises:
            NotTaken: The node confirmed the value and kept another one.
            SdoRefused: The node aborts the transfer.
            SdoSilent: The node does not answer.
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

    def ask(self, index: int, subindex: int = 0) -> None:
        """Request an object without waiting; whoever follows the node's SDO answers gets it.

        Raises:
            BusLost: The interface failed.
        """
        self._request(UPLOAD, index, subindex, b"")

    def post(self, index: int, subindex: int, value: int) -> None:
        """Write an object in its standard size without waiting for the confirmation.

        Raises:
            BusLost: The interface failed.
        """
        size = self._size(index, subindex)
        self._request(DOWNLOAD | (4 - size) << 2, index, subindex, _pack(value, size))

    def _restore(self, written: list[tuple[int, int, int]]) -> None:
        """Write former values back; a value that is refused is passed over, silence ends it."""
        self._written = None
        for index, subindex, before in reversed(written):
            try:
                self.write(index, subindex, before)
            except SdoRefused:
                continue
            except DriverError:
                return

    def _size(self, index: int, subindex: int) -> int:
        variable = self.client.od.get_variable(index, subindex) or _STANDARD.get_variable(index, subindex)
        return len(variable) // 8 if variable is not None and variable.data_type in INTEGER_TYPES else 4

    def _request(self, command: int, index: int, subindex: int, data: bytes) -> None:
        """Send a request of an expedited transfer, CiA 301."""
        head = bytes((command,)) + index.to_bytes(2, "little") + bytes((subindex,))
        self.client.network.send_message(self.client.rx_cobid, head + data.ljust(4, b"\0"))

    def _transfer(
        self, index: int, subindex: int, data: bytes | None, *, whole: bool = False, tries: int = TRIES
    ) -> bytes:
        for left in reversed(range(tries)):
            self.client.begin(index, subindex, is_write=data is not None)
            try:
                if data is not None:
                    self.client.download(index, subindex, data)
                    return b""
                if whole:
                    with self.client.open(index, subindex, buffering=0) as stream:  # type: ignore[no-untyped-call]
                        return bytes(stream.read())
                return bytes(self.client.upload(index, subindex))
            except SdoAbortedError as aborted:
                access: Literal["read", "write"] = "read" if data is None else "write"
                raise SdoRefused(self.node, index, subindex, aborted.code, access) from aborted
            except SdoCommunicationError as error:
                if not left:
                    raise SdoSilent(self.node, index, subindex, str(error)) from error
        raise AssertionError  # the loop returns or raises


def _pack(value: int, size: int) -> bytes:
    return (value % (1 << 8 * size)).to_bytes(size, "little")
