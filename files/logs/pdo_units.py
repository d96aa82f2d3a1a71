"""Conversion of raw counts in PDOs: angle of a wheel or joint [rad], length of the link [m]."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from omnimate.vehicle.parameters import Drive, Encoder, VehicleParameters


class Conversion(NamedTuple):
    """physical = offset + factor * raw.

    The factor is in units per count; the unit is `rad`, `m` or `rad/s`.
    """

    factor: float
    offset: float
    unit: str

    def __call__(self, raw: float) -> float:
        """Return the physical value of raw counts."""
        return self.offset + self.factor * raw


def encoder_conversion(encoder: Encoder, vehicle: VehicleParameters) -> Conversion:
    """Return the conversion of an encoder's counts, before they are unwrapped."""
    if encoder.channel == "link":
        length = vehicle.linkage.length if vehicle.linkage else 0.0
        return Conversion(encoder.scale, length - encoder.zero * encoder.scale, "m")
    zero = encoder.zero if encoder.channel in {"joint_a", "joint_b"} else 0
    return Conversion(encoder.scale, 0.0 - zero * encoder.scale, "rad")


def drive_conversion(drive: Drive) -> Conversion:
    """Return the conversion of a drive's target velocity (60FFh) to wheel speed, forward positive."""
    return Conversion(drive.sign * 2.0 * math.pi / drive.counts_per_turn, 0.0, "rad/s")
