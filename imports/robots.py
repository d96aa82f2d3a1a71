"""A single differential drive that nobody wrote a `vehicle.toml` for."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vehicle.parameters import Bus, Drive, Encoder, VehicleParameters

if TYPE_CHECKING:
    from vehicle.parameters import Channel, Truck

_WHEELS: tuple[Channel, Channel] = ("a.left", "a.right")


def single_truck(
    name: str, truck: Truck, counts_per_turn: float, period: float, *, driven: bool = False
) -> VehicleParameters:
    """Return a robot with one truck whose wheels count 32 bits on nodes 1 and 2.

    Args:
        name: of the robot.
        truck: nominal.
        counts_per_turn: of a wheel.
        period: between two samples [s].
        driven: whether it has drives, on nodes 11 and 12, in the same counts.

    Raises:
        ParameterError: no robot can be so.
    """
    encoders = tuple(
        Encoder(wheel, node, 0x180 + node, 0, 32, signed=True, sign=1, counts_per_turn=counts_per_turn)
        for node, wheel in enumerate(_WHEELS, start=1)
    )
    drives = tuple(
        Drive(wheel, node, 0x200 + node, 1, counts_per_turn) for node, wheel in enumerate(_WHEELS, start=11)
    )
    return VehicleParameters(
        name, {"a": truck}, None, Bus(500_000, period), encoders, drives if driven else ()
    )
