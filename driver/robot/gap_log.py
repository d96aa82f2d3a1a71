"""Follows the gaps of each channel: from the last good sample to the next one, with the reason."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.vehicle.recording import Gap

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.vehicle.parameters import Channel
    from omnimate.vehicle.recording import GapReason

MAX_GAPS = 10_000


class GapLog:
    """The gaps of all channels.

    Args:
        channels: Channels in the order of the samples' columns.

    Attributes:
        gaps: Gaps that have ended, in order of their end; at most `MAX_GAPS`.
    """

    def __init__(self, channels: Sequence[Channel]) -> None:
        self.gaps: list[Gap] = []
        self._channels = tuple(channels)
        self._last_time: float | None = None
        self._open: dict[int, tuple[float, GapReason]] = {}
        self._jumped: set[int] = set()

    def jumped(self, column: int) -> None:
        """Note that the channel of a column was read in the open sample, with an impossible value."""
        self._jumped.add(column)

    def restarted(self, column: int, now: float) -> None:
        """Note that the device of a column has booted, before or in the sample at `now` [s]."""
        start, _ = self._open.get(column, (self._last_good(now), "missing"))
        self._open[column] = (start, "reboot")

    def close(self, present: tuple[bool, ...], now: float) -> None:
        """Take which channels are present in the sample at `now` [s]."""
        if self._open or not all(present):
            for column, is_present in enumerate(present):
                self._follow(column, now, is_present=is_present)
        self._jumped.clear()
        self._last_time = now

    def until(self, now: float) -> tuple[Gap, ...]:
        """Return all gaps; those that are still open end at `now` [s]."""
        still = [
            Gap(self._channels[column], start, now, reason)
            for column, (start, reason) in sorted(self._open.items())
        ]
        return (*self.gaps, *still)

    def _last_good(self, now: float) -> float:
        return now if self._last_time is None else self._last_time

    def _follow(self, column: int, now: float, *, is_present: bool) -> None:
        if not is_present and column not in self._open:
            reason: GapReason = "jump" if column in self._jumped else "missing"
            self._open[column] = (self._last_good(now), reason)
        elif is_present and column in self._open:
            start, reason = self._open.pop(column)
            if len(self.gaps) < MAX_GAPS:
                self.gaps.append(Gap(self._channels[column], start, now, reason))
