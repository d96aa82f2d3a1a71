"""PDO mappings in the SDO traffic of a log, written or read by a master."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from omnimate.files.logs.frames import ERROR, EXTENDED, FD, REMOTE
from omnimate.files.logs.signals import EXTENDED_KEY

if TYPE_CHECKING:
    from collections.abc import Mapping

    from omnimate.files.logs.frames import Frame, Frames

REQUEST, ANSWER = 0x600, 0x580
ABORT = 0x80  # command byte
DOWNLOAD, UPLOADED = 1, 2  # command specifiers of expedited transfers that carry a value
INVALID_BIT, EXTENDED_BIT = 1 << 31, 1 << 29
FIRST_RPDO, FIRST_TPDO = 0x200, 0x180  # predefined COB-IDs of the first PDOs, without the node
PDO_TYPES = ((0x1400, FIRST_RPDO), (0x1800, FIRST_TPDO))  # communication parameters, and these
PREDEFINED = 4  # PDOs with a predefined COB-ID


class Mapped(NamedTuple):
    """An object in a PDO.

    The node sends or receives the PDO.
    """

    node: int
    object: int
    subindex: int
    start_bit: int
    bits: int


class SeenObjects:
    """The last values of the PDO parameters in SDO traffic, by node, index and sub-index."""

    def __init__(self) -> None:
        self.values: dict[tuple[int, int, int], int] = {}
        # the values before the writes that are not answered yet
        self._before: dict[tuple[int, int, int], int | None] = {}

    def take(self, frames: Frames) -> None:
        """Take the values in frames that follow those before."""
        function = frames.can_id & 0x780
        is_sdo = ((function == REQUEST) | (function == ANSWER)) & (frames.length == 8)
        index = frames.data[:, 1].astype(np.int64) | frames.data[:, 2].astype(np.int64) << 8
        is_sdo &= (frames.flags & (EXTENDED | REMOTE | ERROR) == 0) & (index >= 0x1400) & (index < 0x1C00)
        for frame in frames.select(np.flatnonzero(is_sdo)):
            self.take_frame(frame)

    def take_frame(self, frame: Frame) -> None:
        """Take the value that a frame carries; where the node refuses it, the one before is right."""
        function, data = frame.can_id & 0x780, frame.data
        is_classical = not frame.flags & (EXTENDED | REMOTE | ERROR | FD)
        if function not in {REQUEST, ANSWER} or len(data) != 8 or not is_classical:
            return
        command, index = data[0], int.from_bytes(data[1:3], "little")
        carries = command >> 5 == (DOWNLOAD if function == REQUEST else UPLOADED) and command & 0x02
        place = frame.can_id & 0x7F, index, data[3]
        if carries and 0x1400 <= index < 0x1C00:
            if function == REQUEST:
                self._before[place] = self.values.get(place)
            size = 4 - (command >> 2 & 3) if command & 0x01 else 4
            self.values[place] = int.from_bytes(data[4 : 4 + size], "little")
        elif function == ANSWER and place in self._before:
            before = self._before.pop(place)
            if command == ABORT:
                if before is None:
                    del self.values[place]
                else:
                    self.values[place] = before


def seen_objects(frames: Frames) -> dict[tuple[int, int, int], int]:
    """Return the last values of the PDO parameters in SDO traffic, by node, index and sub-index."""
    seen = SeenObjects()
    seen.take(frames)
    return seen.values


def mapped_objects(objects: Mapping[tuple[int, int, int], int]) -> dict[int, tuple[Mapped, ...]]:
    """Return the objects in each PDO, by identifier, to which `EXTENDED_KEY` is added for 29 bits.

    PDO parameters are by node, index and sub-index; a COB-ID that is missing is the predefined one.
    """
    pdos: dict[int, tuple[Mapped, ...]] = {}
    for node in {key[0] for key in objects}:
        for base, first in PDO_TYPES:
            for number in range(0x200):
                default = predefined_cob_id(first, number, node) if number < PREDEFINED else INVALID_BIT
                cob_id = objects.get((node, base + number, 1), default)
                carried = _carried(objects, node, base + 0x200 + number)
                if carried and not cob_id & INVALID_BIT:
                    pdos[_key(cob_id)] = carried
    return pdos


def predefined_cob_id(first: int, number: int, node: int) -> int:
    """Return the predefined COB-ID of a node's PDO, by its number, below `PREDEFINED`, and the first."""
    return first + 0x100 * number + node


def _key(cob_id: int) -> int:
    """Return the identifier in a COB-ID, as keys of signals have it."""
    return cob_id & 0x1FFFFFFF | EXTENDED_KEY if cob_id & EXTENDED_BIT else cob_id & 0x7FF


def _carried(objects: Mapping[tuple[int, int, int], int], node: int, mapping: int) -> tuple[Mapped, ...]:
    carried: list[Mapped] = []
    start = 0
    for number in range(1, objects.get((node, mapping, 0), 64) + 1):
        entry = objects.get((node, mapping, number))
        if not entry or start + (entry & 0xFF) > 64:
            break
        carried.append(Mapped(node, entry >> 16, entry >> 8 & 0xFF, start, entry & 0xFF))
        start += entry & 0xFF
    return tuple(carried)
