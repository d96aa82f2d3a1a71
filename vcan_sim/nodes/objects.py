"""Access to the objects of a device, with checks and reactions (CiA 301 7.4)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.vcan_sim.errors import SdoAbort
from omnimate.vcan_sim.nodes.abort import Abort

if TYPE_CHECKING:
    from collections.abc import Callable

    from omnimate.vcan_sim.nodes.dictionary import Key, ObjectStore


class Objects:
    """The objects of one device, as SDO and PDOs read and write them.

    Attributes:
        store: Values of the objects that are not measured or computed.
        readers: Function that returns an object's present value, by (index, sub-index), for objects
            that are measured or computed instead of stored.
        checks: Function that is called with (sub-index, value) before a value is stored, by index; it
            raises `SdoAbort` to refuse the value.
        reactions: Function that is called with (sub-index, value) after a value was stored, by index.
    """

    def __init__(self, store: ObjectStore) -> None:
        self.store = store
        self.readers: dict[Key, Callable[[], int]] = {}
        self.checks: dict[int, Callable[[int, int], None]] = {}
        self.reactions: dict[int, Callable[[int, int], None]] = {}

    def read(self, index: int, sub: int) -> bytes:
        """Return an object's bytes, as SDO uploads them.

        Raises:
            SdoAbort: There is no such object, or it has no value now.
        """
        reader = self.readers.get((index, sub))
        if reader is None:
            return self.store.data((index, sub))
        return self.store.variable((index, sub)).encode(reader())

    def size(self, index: int, sub: int) -> int | None:
        """Return the size of an object [byte]; None for a string.

        Raises:
            SdoAbort: There is no such object.
        """
        return self.store.variable((index, sub)).size

    def write(self, index: int, sub: int, data: bytes) -> None:
        """Set an object, as SDO downloads and RPDOs do.

        Raises:
            SdoAbort: There is no such object, it is read-only, or the value is not allowed now.
        """
        variable = self.store.variable((index, sub))
        if not variable.writable:
            raise SdoAbort(Abort.READ_ONLY)
        value = variable.decode(data)
        assert isinstance(value, int)  # no string of these devices can be written
        if index in self.checks:
            self.checks[index](sub, value)
        self.store[index, sub] = value
        if index in self.reactions:
            self.reactions[index](sub, value)

    def reader(self, key: Key) -> Callable[[], int]:
        """Return the function by which a PDO reads an object."""
        return self.readers.get(key) or (lambda: self.store[key])
