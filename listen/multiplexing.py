"""Detection of multiplexed messages, in which one byte selects the layout of the others."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from omnimate.listen.code_lengths import flags_value, symbol_code

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping

    from numpy.typing import NDArray

    from omnimate.listen.layout import Layout

# Assumptions on a multiplexor: its values are sent in turn, with few exceptions.
MAX_VALUES = 16  # distinct values
MIN_FRAMES = 24  # frames of each value, from which a layout can be learned
MIN_CHANGE_SHARE = 0.25  # share of frames in which it changes
MAX_ORDER_BITS = 0.25  # [bits per frame] code length of the sequence of its values
PRIOR_BITS = 7.0  # [bits] prior of 1 in 100: few messages are multiplexed
MIN_GAIN = 6.6  # [bits] odds of 99 to 1


class Multiplexed(NamedTuple):
    """A message whose data depend on a byte.

    Attributes:
        start: First bit of that byte, the multiplexor.
        layouts: For each of its values, the layouts of the bytes before it and of those after it, each as
            (first byte, byte after the last, layout).
    """

    start: int
    layouts: Mapping[int, tuple[tuple[int, int, Layout], ...]]


def find_multiplexor(
    data: NDArray[np.uint8], plain: Layout, layout_of: Callable[[NDArray[np.uint8]], Layout]
) -> Multiplexed | None:
    """Return the multiplexor of a message, `(N, length)`, if the description is then shorter than `plain`."""
    best: tuple[float, Multiplexed] | None = None
    for byte, values in _candidates(data):
        column = data[:, byte].astype(np.uint64)
        order = symbol_code(column, 8)
        if order > MAX_ORDER_BITS * len(data):
            continue
        total = -order - flags_value(int(column[0]), 8) - PRIOR_BITS
        layouts: dict[int, tuple[tuple[int, int, Layout], ...]] = {}
        parts = [(first, last) for first, last in ((0, byte), (byte + 1, data.shape[1])) if first < last]
        for value in values:
            rows = data[data[:, byte] == value]
            layouts[value] = tuple((first, last, layout_of(rows[:, first:last])) for first, last in parts)
            total += sum(layout.log2_evidence for *_, layout in layouts[value])
        if total > plain.log2_evidence + MIN_GAIN and (best is None or total > best[0]):
            best = total, Multiplexed(8 * byte, layouts)
    return None if best is None else best[1]


def _candidates(data: NDArray[np.uint8]) -> Iterator[tuple[int, list[int]]]:
    """Yield the bytes that may be a multiplexor, each as (number of the byte, its values)."""
    if data.shape[1] < 2 or len(data) < 2 * MIN_FRAMES:
        return
    for byte in range(data.shape[1]):
        values, counts = np.unique(data[:, byte], return_counts=True)
        changes = np.count_nonzero(np.diff(data[:, byte].astype(np.int64)))
        is_one = 2 <= len(values) <= MAX_VALUES and counts.min() >= MIN_FRAMES
        if is_one and changes > MIN_CHANGE_SHARE * len(data):
            yield byte, values.tolist()
