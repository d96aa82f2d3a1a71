"""Signals: numbers in frames, with bit position and conversion."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from omnimate.files.logs.frames import Frames

EXTENDED_KEY = 1 << 31  # in a DBC file, and in keys of signals by identifier: a 29-bit identifier
_FLOATS = {32: ("<f", "<I", np.float32, np.uint32), 64: ("<d", "<Q", np.float64, np.uint64)}
FLOAT_WIDTHS = tuple(_FLOATS)  # [bits]


@dataclass(frozen=True, slots=True)
class Signal:
    """A number in the data of a frame: physical = offset + factor * raw.

    Attributes:
        name: Name of the signal.
        start_bit: Its lowest bit in the data, taken as one little-endian number; with `is_big_endian` its
            highest bit as DBC files count: 8 for each byte before, and 7 for the highest bit of a byte.
        bits: Width.
        signed: Whether it is two's complement.
        factor: Physical value of one count.
        offset: Physical value at 0 counts.
        unit: Unit of the physical value; may be empty.
        is_big_endian: Whether it is in Motorola's byte order.
        is_float: Whether the bits are a number of IEEE 754, of 32 or 64 bits.
        counts: What the raw number is called beside the physical one; empty where it is not shown.
        choices: Words for raw values.
        switch: Signal and raw values with which this one is there, where the data are multiplexed.
    """

    name: str
    start_bit: int
    bits: int
    signed: bool = False
    factor: float = 1.0
    offset: float = 0.0
    unit: str = ""
    is_big_endian: bool = False
    is_float: bool = False
    counts: str = ""
    choices: Mapping[int, str] = field(default_factory=dict)
    switch: tuple[Signal, tuple[int, ...]] | None = None

    @property
    def shift(self) -> int:
        """Number of the lowest bit in the 8 data bytes, taken as one number of its byte order."""
        if not self.is_big_endian:
            return self.start_bit
        return 64 - (self.start_bit // 8 * 8 + 7 - self.start_bit % 8) - self.bits

    @property
    def length(self) -> int:
        """Number of data bytes that a frame needs to hold it."""
        last = 63 - self.shift if self.is_big_endian else self.start_bit + self.bits - 1
        return last // 8 + 1

    def raw(self, data: bytes) -> int:
        """Return the whole number in the data, which are as long as `length`; of a float, its bits."""
        word = int.from_bytes(data[:8].ljust(8, b"\0"), "big" if self.is_big_endian else "little")
        value = word >> self.shift & ((1 << self.bits) - 1)
        is_negative = self.signed and not self.is_float and value >> (self.bits - 1)
        return value - (1 << self.bits) if is_negative else value

    def is_in(self, data: bytes) -> bool:
        """Return whether the data hold it, by what their multiplexor says."""
        if self.switch is None:
            return True
        on, raw_values = self.switch
        return on.is_in(data) and len(data) >= on.length and on.raw(data) in raw_values

    def value(self, data: bytes) -> float:
        """Return the physical value in the data, which are as long as `length`."""
        raw: float = self.raw(data)
        if self.is_float:
            number, word, *_ = _FLOATS[self.bits]
            raw = struct.unpack(number, struct.pack(word, int(raw)))[0]
        return self.offset + self.factor * raw

    def values(self, frames: Frames) -> NDArray[np.float64]:
        """Return the physical value in each frame, nan where it is not in there, shape `(N,)`."""
        order = ">u8" if self.is_big_endian else "<u8"
        words = np.ascontiguousarray(frames.data).view(order).reshape(-1).astype(np.uint64)
        left = np.uint64(64 - self.shift - self.bits)
        bits = words << left
        if self.is_float:
            _, _, number, word = _FLOATS[self.bits]
            raw = (bits >> np.uint64(64 - self.bits)).astype(word).view(number).astype(np.float64)
        elif self.signed:
            raw = (bits.view(np.int64) >> np.int64(64 - self.bits)).astype(np.float64)
        else:
            raw = (bits >> np.uint64(64 - self.bits)).astype(np.float64)
        is_there = frames.length >= self.length
        if self.switch is not None:
            on, raw_values = self.switch
            is_there &= np.isin(on.values(frames), [on.offset + on.factor * raw for raw in raw_values])
        return np.where(is_there, self.offset + self.factor * raw, np.nan)

    def in_words(self, data: bytes) -> str:
        """Return its name and value in the data of a frame."""
        if len(data) < self.length:
            return f"{self.name}: wrong length, {len(data)} bytes"
        raw = self.raw(data)
        if raw in self.choices:
            return f"{self.name} = {self.choices[raw]} ({raw})"
        unit = f" {self.unit}" if self.unit else ""
        is_raw = not self.is_float and self.factor == 1 and self.offset == 0  # then also beyond 53 bits
        number = raw if is_raw else self.value(data)
        text = f"{number:.6g}" if self.counts or self.is_float or number % 1 else f"{int(number)}"
        return f"{self.name} = {text}{unit}" + (f" ({raw} {self.counts})" if self.counts else "")
