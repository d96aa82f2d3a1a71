"""Assignment of encoders to wheels, and their signs, which a `vehicle.toml` may have wrong."""

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
    """Assignment of the encoders of one truck to its wheels, and their signs."""

    exchanged: bool = False  # whether left and right are exchanged
    backward: tuple[bool, bool] = (False, False)  # which of (left, right) counts down if it rolls forward

    @property
    def faults(self) -> int:
        """Number of errors in vehicle.toml that it means."""
        return self.exchanged + sum(self.backward)

    def wheels(self, turned: Array) -> Array:
        """Return the turns (N, 2) of the left and the right wheel from those described as left and right."""
        sides = turned[:, ::-1] if self.exchanged else turned
        return np.where(self.backward, -sides, sides)

    def rewired(self, encoder: Encoder, truck: TruckName) -> Encoder:
        """Return an encoder with its actual wheel and sign; those of other trucks unchanged."""
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


WIRINGS = sorted(
    (
        Wiring(exchanged, (left, right))
        for exchanged, left, right in itertools.product((False, True), repeat=3)
    ),
    key=lambda wiring: wiring.faults,
)
