"""A robot with a single differential drive, for data without a `vehicle.toml`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.files.errors import MappingError
from omnimate.vehicle.file import load_vehicle
from omnimate.vehicle.parameters import Bus, Encoder, ParameterError, Truck, VehicleParameters

if TYPE_CHECKING:
    from pathlib import Path

    from omnimate.files.importers.tables import Table
    from omnimate.vehicle.parameters import Channel

_WHEELS: tuple[Channel, Channel] = ("a.left", "a.right")
_ANY_PERIOD = 0.02  # [s]; it is replaced by that of the data


def single_truck(name: str, truck: Truck, counts_per_turn: float, period: float) -> VehicleParameters:
    """Return a robot with one truck whose wheels count 32 bits on nodes 1 and 2.

    The period is the time between two samples [s].

    Raises:
        ParameterError: The parameters are not those of a possible robot.
    """
    encoders = tuple(
        Encoder(wheel, node, 0x180 + node, 0, 32, signed=True, sign=1, counts_per_turn=counts_per_turn)
        for node, wheel in enumerate(_WHEELS, start=1)
    )
    return VehicleParameters(name, {"a": truck}, None, Bus(500_000, period), encoders)


def robot_of(mapping: Table, folder: Path, vehicle: VehicleParameters | None) -> VehicleParameters:
    """Return the robot of a mapping.

    The mapping has a path `vehicle`, relative to the folder, or a single differential drive, `[robot]`; a
    given vehicle replaces both.

    Raises:
        MappingError: The mapping has neither, or its robot is not possible.
        VehicleFileError: The file `vehicle` cannot be read.
    """
    path, entry = mapping.text("vehicle", ""), mapping.table("robot")
    if vehicle is not None:
        return vehicle
    if path:
        return load_vehicle(folder / path)
    if not entry.names():
        raise MappingError(mapping.source, 'no robot; expected vehicle = "vehicle.toml" or a table [robot]')
    common = entry.number("wheel_diameter", 0.0)
    sides = (entry.number(f"wheel_diameter_{side}", common) for side in ("left", "right"))
    name = entry.text("name", "robot")
    try:
        truck = Truck(entry.number("wheelbase"), *sides)
        robot = single_truck(name, truck, entry.number("counts_per_turn"), _ANY_PERIOD)
    except ParameterError as error:
        raise MappingError(entry.source, str(error)) from error
    entry.done()
    return robot
