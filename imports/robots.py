"""A single differential drive that nobody wrote a `vehicle.toml` for."""

from __future__ import annotations

from typing import TYPE_CHECKING

from imports.errors import MappingError
from vehicle.file import load_vehicle
from vehicle.parameters import Bus, Drive, Encoder, ParameterError, Truck, VehicleParameters

if TYPE_CHECKING:
    from pathlib import Path

    from imports.tables import Table
    from vehicle.parameters import Channel

_WHEELS: tuple[Channel, Channel] = ("a.left", "a.right")
_ANY_PERIOD = 0.02  # [s]; the data's own replaces it


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


def robot_of(mapping: Table, folder: Path, vehicle: VehicleParameters | None) -> VehicleParameters:
    """Return the robot that a mapping is of.

    Args:
        mapping: with `vehicle`, a path, or `[robot]`, a single differential drive.
        folder: that the path is relative to.
        vehicle: given otherwise; it goes before both.

    Raises:
        MappingError: there is neither, or no robot can be so.
        VehicleFileError: `vehicle` cannot be read.
    """
    path, own = mapping.text("vehicle", ""), mapping.table("robot")
    if vehicle is not None:
        return vehicle
    if path:
        return load_vehicle(folder / path)
    if not own.names():
        raise MappingError(mapping.source, 'no robot; expected vehicle = "vehicle.toml" or a table [robot]')
    common = own.number("wheel_diameter", 0.0)
    sides = (own.number(f"wheel_diameter_{side}", common) for side in ("left", "right"))
    name = own.text("name", "robot")
    try:
        truck = Truck(own.number("wheelbase"), *sides)
        robot = single_truck(name, truck, own.number("counts_per_turn"), _ANY_PERIOD)
    except ParameterError as error:
        raise MappingError(own.source, str(error)) from error
    own.done()
    return robot
