"""Readings of the linkage from the counts of a sample."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.vehicle.parameters import CHANNELS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.vehicle.parameters import VehicleParameters


class LinkReader:
    """Converts the counts of a sample to joint angles and link length; None for a single truck."""

    def __init__(self, vehicle: VehicleParameters) -> None:
        self._columns: list[tuple[int, int, float]] = []
        self._length = 0.0
        if vehicle.linkage is not None:
            self._length = vehicle.linkage.length
            for channel in CHANNELS[4:]:
                encoder = vehicle.encoder(channel)
                self._columns.append((vehicle.channels.index(encoder.channel), encoder.zero, encoder.scale))

    def read(self, counts: Sequence[int]) -> tuple[float, float, float] | None:
        """Return joint_a [rad], joint_b [rad] and the length [m] for counts in the order of the channels."""
        if not self._columns:
            return None
        joint_a, joint_b, link = [(counts[column] - zero) * scale for column, zero, scale in self._columns]
        return joint_a, joint_b, self._length + link
