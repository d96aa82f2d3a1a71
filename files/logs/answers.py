"""Which of a PDO's frames answers a SYNC, where some come late: one law, live and over a whole log.

Nothing in a PDO says which SYNC it answers, but a node answers in order, and once. So a SYNC without an
answer is owed one. As long as answers are owed, the first frames after the next SYNC may be those. A frame
counts as current where it is one more than is owed, where it comes alone after one missed SYNC, or where it
comes alone and as soon after SYNC as the node answered before. A burst of late answers begins at any
moment; should it begin at the usual one, the frames that follow it are late all the same. Where a node
answers alone but later than before, the second such frame counts: the answers that are owed were lost.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

ALONE = 2  # samples with one frame each after which answers that are owed count as lost
TOLERANCE = 0.25  # SYNC periods by which an answer may come later than before


class Owed:
    """How many answers a PDO owes.

    Args:
        period: Time between two SYNCs [s].

    Attributes:
        count: SYNCs whose answers may still come.
        usual: Time from SYNC to the last answer of which there was no doubt [s]; nan before the first.
    """

    def __init__(self, period: float) -> None:
        self.count = 0
        self.usual = math.nan
        self._alone = 0
        self._tolerance = TOLERANCE * period

    def close(self, frames: int, latency: float) -> int | None:
        """End a sample for which answers are owed, or that has none.

        Args:
            frames: Frames that came in this sample.
            latency: Time from SYNC to the last of them [s]; nan where it is unknown.

        Returns:
            Which frame is current, from 0; None for none.
        """
        owed = self.count
        self._alone = self._alone + 1 if owed and frames == 1 else 0
        is_usual = not latency > self.usual + self._tolerance  # also where one of them is unknown
        if frames > owed or (frames == 1 and (owed == 1 or is_usual or self._alone == ALONE)):
            self.settle()
            return owed if frames > owed else 0
        self.count += 1 - frames
        return None

    def settle(self) -> None:
        """Expect nothing of the past any longer."""
        self.count = self._alone = 0

    def late(self) -> None:
        """Note that a frame came between two samples."""
        self.count = max(0, self.count - 1)


def current(
    frames: NDArray[np.intp],
    first: NDArray[np.float64],
    last: NDArray[np.float64],
    period: float,
) -> NDArray[np.intp]:
    """Return for a whole log which frame of each sample is current: what `Owed` says sample by sample.

    Args:
        frames: Number of frames in each sample, `(N,)`.
        first: Time from SYNC to the first frame of each sample, `(N,)` [s]; nan where there is none.
        last: The same for the last frame.
        period: Time between two SYNCs [s].

    Returns:
        Place of the current frame among those of its sample, from 0; -1 for none; shape `(N,)`.
    """
    places = np.where(frames > 0, 0, -1)
    empty = np.flatnonzero(frames == 0)
    owed, at = Owed(period), 0
    while (following := int(np.searchsorted(empty, at))) < len(empty):
        begin = int(empty[following])
        if begin > at:  # the sample before is one without a doubt
            owed.usual = float(first[begin - 1])
        for at in range(begin, len(frames)):
            place = owed.close(int(frames[at]), float(last[at]))
            places[at] = -1 if place is None else place
            if not owed.count:
                break
        at += 1
    return places
