"""The objects of one node as numbers, read and written by SDO."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from canopen.objectdictionary.datatypes import INTEGER_TYPES
from canopen.sdo.exceptions import SdoAbortedError, SdoCommunicationError

from omnimate.driver.errors import NotTaken, SdoRefused, SdoSilent

if TYPE_CHECKING:
    from omnimate.driver.sdo_client import PumpedSdoClient

TRIES = 3
# SDO abort codes, CiA 301
OBJECT_ABSENT = frozenset({0x06010000, 0x06010001, 0x06020000, 0x06090011, 0x08000024, 0x060A0023})
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

    def read(self, index: int, subindex: int = 0) -> int:
        """Return an object as an unsigned number.

        Raises:
            SdoRefused: The node aborts the transfer.
            SdoSilent: The node does not answer.
        """
        return int.from_bytes(self._transfer(index, subindex, None), "little")

    def find(self, index: int, subindex: int = 0) -> int | None:
        """Return an object as an unsigned number, or None where the device has no such object.

        Raises:
            SdoRefused: The node aborts the transfer for another reason than a missing object.
            SdoSilent: The node does not answer.
        """
        try:
            return self.read(index, subindex)
        except SdoRefused as refused:
            if refused.abort_code in OBJECT_ABSENT:
                return None
            raise

    def write(self, index: int, subindex: int, value: int) -> None:
        """Write an object in its standard size, or in the size of the device's object where that differs.

        Raises:
            SdoRefused: The node aborts the transfer.
            SdoSilent: The node does not answer.
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
            NotTaken: The node confirmed the value and kept another one.
            SdoRefused: The node aborts the transfer.
            SdoSilent: The node does not answer.
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
            self.client.begin(index, subindex)
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
