"""Which encoder is which wheel, and which way it counts: what a `vehicle.toml` or a table may have wrong."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from omnimate.vehicle.parameters import Channel, Encoder, TruckName
    from omnimate.vehicle.se2 import Array


@dataclass(frozen=True, slots=True)
class Wiring:
    """Which encoder is which wheel, and which way it counts.

    Attributes:
        exchanged: left is right and right is left.
        backward: (left, right) wheels that count down when they roll forward.
    """

    exchanged: bool = False
    backward: tuple[bool, bool] = (False, False)

    @property
    def faults(self) -> int:
        """How many things are wrong in it."""
        return self.exchanged + sum(self.backward)

    def wheels(self, turned: Array) -> Array:
        """Return the turns (N, 2) of the left and the right wheel from those described as left and right."""
        sides = turned[:, ::-1] if self.exchanged else turned
        return np.where(self.backward, -sides, sides)

    def rewired(self, encoder: Encoder, truck: TruckName) -> Encoder:
        """Return an encoder of a truck as what it is; those of others as they are."""
        sides: list[Channel] = ["a.left", "a.right"] if truck == "a" else ["b.left", "b.right"]
        if encoder.channel not in sides:
            return encoder
        side = sides.index(encoder.channel) ^ self.exchanged
        sign = -encoder.sign if self.backward[side] else encoder.sign
        return replace(encoder, channel=sides[side], sign=sign)

    def __str__(self) -> str:
        """Return what is wrong, in words."""
        left, right = self.backward
        words = ["left and right are exchanged"] if self.exchanged else []
        if left or right:
            which = (
                "both wheels count" if left and right else f"the {'left' if left else 'right'} wheel counts"
            )
            words.append(f"{which} backwards")
        return " and ".join(words) or "the wheels are as described"


_WAYS = (False, True)
WIRINGS = sorted(
    itertools.starmap(Wiring, itertools.product(_WAYS, itertools.product(_WAYS, _WAYS))),
    key=lambda one: one.faults,
)
