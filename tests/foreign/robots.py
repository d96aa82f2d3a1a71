"""Robots whose encoders and drives are foreign devices."""

from __future__ import annotations

from omnimate.vehicle.parameters import Bus, Drive, Encoder, Linkage, Truck, VehicleParameters
from tests.foreign.devices import ForeignDrive, ForeignEncoder

FAMILY = {
    "encoder": ForeignEncoder,
    "drive": ForeignDrive,
}  # what makes devices; the fixture `family` sets it
COUNTS = 40000
WHEELS = ("a.left", "a.right", "b.left", "b.right")
FIRST_DRIVE = 17


def foreign_encoder(node):
    """Return an encoder."""
    return FAMILY["encoder"](node)


def encoder(channel, node):
    """Return an encoder of `vehicle.toml`."""
    unit = {"counts_per_metre": 10000} if channel == "link" else {"counts_per_turn": COUNTS}
    return Encoder(channel, node, 0x180 + node, 0, 32, signed=False, sign=1, **unit)


def two_trucks(period=0.015):
    """Return a robot of seven encoders, nodes 1 to 7, and four drives, nodes 17 to 20."""
    channels = (*WHEELS, "joint_a", "joint_b", "link")
    drives = tuple(
        Drive(wheel, FIRST_DRIVE + number, 0x200 + FIRST_DRIVE + number, 1, COUNTS)
        for number, wheel in enumerate(WHEELS)
    )
    return VehicleParameters(
        "foreign",
        {name: Truck(0.34, 0.15, 0.15) for name in ("a", "b")},
        Linkage(1.0),
        Bus(500_000, period),
        tuple(encoder(channel, node) for node, channel in enumerate(channels, 1)),
        drives,
    )


def devices(status=None, **habits):
    """Return the devices of `two_trucks`; `status` says where its drives have their status word."""
    encoders = [foreign_encoder(node) for node in range(1, 8)]
    return [
        *encoders,
        *(FAMILY["drive"](FIRST_DRIVE + number, encoders[number], status, **habits) for number in range(4)),
    ]
