"""Reference vehicles for demonstrations and tests: nominal robots of the papers' size."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from omnimate.vehicle.parameters import (
    CHANNELS,
    JOINTS,
    WHEELS,
    Bus,
    Channel,
    Drive,
    Encoder,
    Linkage,
    Truck,
    VehicleParameters,
)

WHEEL_COUNTS_PER_TURN = 40_000.0
"""Resolution times gear; at 150 mm it makes 0.012 mm per count."""

JOINT_COUNTS_PER_TURN = 2**14
"""14 bits are 0.022 degrees, a tenth of what the sonar calibrator resolves; C used 360/1024 degrees.

Zero is the middle of the turn, so that a joint does not wrap within its travel.
"""

LINK_COUNTS_PER_METRE = 10_000.0
"""0.1 mm, as in C section 6."""

LINK_ZERO = 5_000
"""So that the counter, from 0 on, reaches half a metre to either side of the link's length."""

_TRUCK = Truck(wheelbase=0.340, wheel_diameter_left=0.150, wheel_diameter_right=0.150)
_FIRST_DRIVE_NODE = 11


def reference_vehicle() -> VehicleParameters:
    """Return a nominal two-truck robot: seven encoders on nodes 1 to 7, four drives on nodes 11 to 14."""
    encoders = tuple(_encoder(channel, node) for node, channel in enumerate(CHANNELS, start=1))
    drives = tuple(_drive(wheel, node) for node, wheel in enumerate(WHEELS, start=_FIRST_DRIVE_NODE))
    return VehicleParameters(
        name="omnimate",
        trucks={"a": _TRUCK, "b": _TRUCK},
        linkage=Linkage(length=1.000),
        bus=Bus(bitrate=500_000, sync_period=0.015),
        encoders=encoders,
        drives=drives,
    )


def reference_single() -> VehicleParameters:
    """Return a nominal robot of one truck: encoders on nodes 1 and 2, drives on nodes 11 and 12."""
    both = reference_vehicle()
    return replace(
        both,
        name="labmate",
        trucks={"a": _TRUCK},
        linkage=None,
        encoders=both.encoders[:2],
        drives=both.drives[:2],
    )


def _encoder(channel: Channel, node: int) -> Encoder:
    """Return an encoder; the right wheels' face the other way and count backwards."""
    make = partial(Encoder, channel=channel, node=node, cob_id=0x180 + node, start_bit=0, bits=32)
    if channel == "link":
        return make(signed=False, sign=1, counts_per_metre=LINK_COUNTS_PER_METRE, zero=LINK_ZERO)
    if channel in JOINTS:
        turn = JOINT_COUNTS_PER_TURN
        return make(signed=False, sign=1, counts_per_turn=float(turn), zero=turn // 2, range=turn)
    return make(signed=True, sign=_facing(channel), counts_per_turn=WHEEL_COUNTS_PER_TURN)


def _drive(wheel: Channel, node: int) -> Drive:
    """Return a drive; the right wheels' motors face the other way too."""
    return Drive(wheel, node, 0x200 + node, _facing(wheel), WHEEL_COUNTS_PER_TURN)


def _facing(wheel: Channel) -> int:
    return -1 if wheel.endswith("right") else 1
