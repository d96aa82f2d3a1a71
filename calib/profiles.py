"""Calibrations by name: one robot on several floors or under several loads.

A small TOML file, one table for each profile and truck:

    [concrete.a]
    wheelbase = 0.33617
    wheel_diameter_left = 0.149937
    wheel_diameter_right = 0.150063
"""

from __future__ import annotations

from dataclasses import asdict, fields
from pathlib import Path
from typing import TYPE_CHECKING

import tomli_w

from omnimate.calib.apply import corrected_vehicle
from omnimate.calib.errors import CalibrationError
from omnimate.vehicle.atomic import write_text
from omnimate.vehicle.errors import TableError
from omnimate.vehicle.parameters import TRUCKS, Truck
from omnimate.vehicle.tables import dataclass_of, read_toml

if TYPE_CHECKING:
    from collections.abc import Mapping

    from omnimate.vehicle.parameters import TruckName, VehicleParameters

Profile = dict["TruckName", Truck]

_KEYS = tuple(field.name for field in fields(Truck))


def load_profiles(path: Path | str) -> dict[str, Profile]:
    """Return the profiles of a file.

    Raises:
        CalibrationError: The file cannot be read, or a table in it does not describe a possible truck.
    """
    path = Path(path)
    try:
        document = read_toml(path)
    except TableError as error:
        raise CalibrationError(path, f"not a file of profiles: {error}") from error
    try:
        return {name: _profile(name, table) for name, table in document.items()}
    except TableError as error:
        raise CalibrationError(path, str(error)) from error


def save_profile(path: Path | str, name: str, profile: Mapping[TruckName, Truck]) -> None:
    """Add a profile to a file, or replace it; other profiles are unchanged.

    Raises:
        CalibrationError: The existing file holds no profiles, or the name is empty.
    """
    path = Path(path)
    if not name.strip():
        raise CalibrationError(path, "a profile needs a name, such as that of its floor")
    profiles: dict[str, Mapping[TruckName, Truck]] = {**load_profiles(path)} if path.exists() else {}
    profiles[name] = profile
    tables = {
        profile_name: {truck: asdict(size) for truck, size in trucks.items()}
        for profile_name, trucks in sorted(profiles.items())
    }
    write_text(path, tomli_w.dumps(tables))


def with_profile(vehicle: VehicleParameters, path: Path | str, name: str) -> VehicleParameters:
    """Return a robot with the trucks of a profile.

    Raises:
        CalibrationError: The file has no such profile, or the profile is of another robot.
    """
    profiles = load_profiles(path)
    if name not in profiles:
        raise CalibrationError(path, f"no profile {name!r}; it holds {', '.join(profiles) or 'none'}")
    for truck in profiles[name]:
        if truck not in vehicle.trucks:
            raise CalibrationError(path, f"profile {name!r} has a truck {truck}; {vehicle.name} has none")
    return corrected_vehicle(vehicle, profiles[name])


def _profile(name: str, table: object) -> Profile:
    if not isinstance(table, dict) or not table:
        raise TableError(name, f"expected tables [{name}.a] with {', '.join(_KEYS)}")
    for truck in table:
        if truck not in TRUCKS:
            raise TableError(f"{name}.{truck}", "unknown truck; expected a or b")
    return {truck: dataclass_of(Truck, values, f"{name}.{truck}") for truck, values in table.items()}
