"""CAN frames of a bus: single frames, and logs as named arrays."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

# Bits of `flags`.
EXTENDED = 1  # 29-bit identifier
REMOTE = 2  # remote transmission request: a length without data
ERROR = 4  # error frame of the adapter, not of the bus
FD = 8  # CAN FD, with up to 64 bytes (ISO 11898-1)
RECEIVED = 16  # the log says that the recorder received it
SENT = 32  # the log says that the recorder sent it itself
BRS = 64  # CAN FD: the bit rate was switched for the data
ESI = 128  # CAN FD: the sender was error passive

DEFAULT_CHANNEL = "can0"
NANOSECOND = 1_000_000_000  # of these in a second
_COLUMNS = ("time", "can_id", "length", "data", "flags", "channel")  # arrays of a log
_TAIL_LENGTH = 56  # bytes of a CAN FD frame behind the first eight


class Frame(NamedTuple):
    """One CAN frame.

    Attributes:
        time: Time at which the frame was seen on the bus [s].
        can_id: Identifier without flag bits.
        data: 0 to 8 bytes, up to 64 in a CAN FD frame; empty in a remote frame.
        flags: Sum of EXTENDED, REMOTE, ERROR, FD, RECEIVED, SENT, BRS and ESI, where they apply.
        length: Number of bytes of data, or asked for by a remote frame; None takes it from the data.
        channel: Name of the interface.
    """

    time: float
    can_id: int
    data: bytes = b""
    flags: int = 0
    length: int | None = None
    channel: str = DEFAULT_CHANNEL

    @property
    def size(self) -> int:
        """Number of bytes of data, or asked for by a remote frame."""
        return len(self.data) if self.length is None else self.length


@dataclass(frozen=True, slots=True)
class Frames:
    """A log of CAN frames, in the order in which it was written.

    Attributes:
        time: Time of each frame [s], shape `(N,)`.
        can_id: Identifiers without flag bits, shape `(N,)`.
        length: Number of bytes of data, or asked for by a remote frame, shape `(N,)`.
        data: First eight bytes of data, padded with zeros, shape `(N, 8)`.
        flags: Sums as in `Frame`, shape `(N,)`.
        channel: Interface of each frame as an index into `channels`, shape `(N,)`.
        channels: Names of the interfaces.
        tail: Further bytes of CAN FD frames, padded with zeros, shape `(N, 56)`; None where there are none.
    """

    time: NDArray[np.float64]
    can_id: NDArray[np.uint32]
    length: NDArray[np.uint8]
    data: NDArray[np.uint8]
    flags: NDArray[np.uint8]
    channel: NDArray[np.uint8]
    channels: tuple[str, ...] = (DEFAULT_CHANNEL,)
    tail: NDArray[np.uint8] | None = None

    def __post_init__(self) -> None:
        count = len(self.time)
        arrays = [getattr(self, name) for name in _COLUMNS]
        if any(len(array) != count for array in arrays) or self.data.shape != (count, 8):
            raise ValueError(f"arrays of {[array.shape for array in arrays]} do not belong to {count} frames")
        for array in arrays:
            array.flags.writeable = False

    def __len__(self) -> int:
        return len(self.time)

    def __iter__(self) -> Iterator[Frame]:
        rows = zip(
            self.time.tolist(),
            self.can_id.tolist(),
            self.length.tolist(),
            self.flags.tolist(),
            self.channel.tolist(),
            strict=True,
        )
        whole = self.data if self.tail is None else np.hstack((self.data, self.tail))
        data, width = whole.tobytes(), whole.shape[1]
        for index, (time, can_id, length, flags, channel) in enumerate(rows):
            payload = b"" if flags & REMOTE else data[width * index : width * index + length]
            yield Frame(time, can_id, payload, flags, length, self.channels[channel])

    def select(self, rows: NDArray[np.generic] | slice) -> Frames:
        """Return the frames of a mask (N,), of indices (K,), or of a slice."""
        tail = None if self.tail is None else self.tail[rows]
        return replace(self, **{name: getattr(self, name)[rows] for name in _COLUMNS}, tail=tail)

    def words(self) -> NDArray[np.uint64]:
        """Return the first eight bytes as a little-endian number per frame, `(N,)`, as CiA 301 packs PDOs."""
        return np.ascontiguousarray(self.data).view("<u8").reshape(-1)


def frames_of(rows: Iterable[Frame], channels: tuple[str, ...] = ()) -> Frames:
    """Return frames as arrays; `channels` are the interfaces that keep their numbers of an earlier block."""
    rows = list(rows)
    channels = tuple(dict.fromkeys((*channels, *(row.channel for row in rows)))) or (DEFAULT_CHANNEL,)
    number = {name: index for index, name in enumerate(channels)}
    return Frames(
        np.array([row.time for row in rows], np.float64),
        np.array([row.can_id for row in rows], np.uint32),
        np.array([row.size for row in rows], np.uint8),
        np.frombuffer(b"".join(row.data[:8].ljust(8, b"\0") for row in rows), np.uint8).reshape(-1, 8).copy(),
        np.array([row.flags for row in rows], np.uint8),
        np.array([number[row.channel] for row in rows], np.uint8),
        channels,
        tail_of(len(rows), {index: row.data for index, row in enumerate(rows) if len(row.data) > 8}),
    )


def tail_of(count: int, long: Mapping[int, bytes]) -> NDArray[np.uint8] | None:
    """Return the tail of frames, of which some, by their index, have more than eight bytes of data."""
    if not long:
        return None
    tail = np.zeros((count, _TAIL_LENGTH), np.uint8)
    for index, data in long.items():
        tail[index, : len(data) - 8] = np.frombuffer(data, np.uint8)[8:]
    return tail


def concatenate(logs: Sequence[Frames]) -> Frames:
    """Return the frames of all logs, one after the other; channels are matched by name."""
    channels = tuple(dict.fromkeys(name for log in logs for name in log.channels)) or (DEFAULT_CHANNEL,)
    if not logs:
        return frames_of(())
    columns = {name: np.concatenate([getattr(log, name) for log in logs]) for name in _COLUMNS}
    numbers = [np.array([channels.index(name) for name in log.channels], np.uint8) for log in logs]
    columns["channel"] = np.concatenate(
        [number[log.channel] for number, log in zip(numbers, logs, strict=True)]
    )
    tail = None
    if any(log.tail is not None for log in logs):
        empty = np.zeros((1, _TAIL_LENGTH), np.uint8)
        tail = np.concatenate(
            [np.repeat(empty, len(log), axis=0) if log.tail is None else log.tail for log in logs]
        )
    return Frames(**columns, channels=channels, tail=tail)


def nanoseconds(time: float) -> int:
    """Return a time [s] as whole nanoseconds, which divided by 1e9 are the same time again.

    A double has steps of 240 ns for present dates. If it equals a whole number of microseconds, as in a
    candump log, the result ends in three zeros, without digits that were not measured.
    """
    micros = round(time * 1e6)
    if micros / 1e6 == time:
        return micros * 1000
    whole = math.floor(time)
    return whole * NANOSECOND + round((time - whole) * NANOSECOND)
