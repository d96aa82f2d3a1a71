"""Calibrations by name: one robot on several floors or under several loads.

A small TOML file, one table for each profile and truck:

    [concrete.a]
    wheelbase = 0.33617
    wheel_diameter_left = 0.149937
    wheel_diameter_right = 0.150063
"""

from __future__ import annotations

import tomllib
from dataclasses import asdict, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import tomli_w

from calib.apply import corrected_vehicle
from calib.errors import CalibrationError
from vehicle.atomic import write_text
from vehicle.parameters import TRUCKS, ParameterError, Truck

if TYPE_CHECKING:
    from collections.abc import Mapping

    from vehicle.parameters import TruckName, VehicleParameters

Profile = dict["TruckName", Truck]

_KEYS = tuple(field.name for field in fields(Truck))


def load_profiles(path: Path | str) -> dict[str, Profile]:
    """Return the profiles of a file.

    Raises:
        CalibrationError: it cannot be read, or a table in it is not that of a possible truck.
    """
    path = Path(path)
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise CalibrationError(path, f"no file of profiles: {error}") from error
    return {name: _profile(path, name, table) for name, table in document.items()}


def save_profile(path: Path | str, name: str, profile: Mapping[TruckName, Truck]) -> None:
    """Add a profile to a file, or replace it there; the others stay.

    Raises:
        CalibrationError: the file that is there holds something else, or the name is empty.
    """
    path = Path(path)
    if not name.strip():
        raise CalibrationError(path, "a profile needs a name, such as that of its floor")
    profiles: dict[str, Mapping[TruckName, Truck]] = {**load_profiles(path)} if path.exists() else {}
    profiles[name] = profile
    tables = {
        one: {truck: asdict(size) for truck, size in trucks.items()}
        for one, trucks in sorted(profiles.items())
    }
    write_text(path, tomli_w.dumps(tables))


def with_profile(vehicle: VehicleParameters, path: Path | str, name: str) -> VehicleParameters:
    """Return a robot with the trucks of a profile.

    Raises:
        CalibrationError: the file has no such profile, or it is of another robot.
    """
    profiles = load_profiles(path)
    if name not in profiles:
        raise CalibrationError(path, f"no profile {name!r}; it holds {', '.join(profiles) or 'none'}")
    for truck in profiles[name]:
        if truck not in vehicle.trucks:
            raise CalibrationError(path, f"profile {name!r} has a truck {truck}; {vehicle.name} has none")
    return corrected_vehicle(vehicle, profiles[name])


def _profile(path: Path, name: str, table: Any) -> Profile:  # noqa: ANN401  # from TOML
    if not isinstance(table, dict) or not table:
        raise CalibrationError(path, f"{name}: expected tables [{name}.a] with {', '.join(_KEYS)}")
    return {truck: _truck(path, f"{name}.{truck}", truck, values) for truck, values in table.items()}


def _truck(path: Path, where: str, name: str, values: Any) -> Truck:  # noqa: ANN401  # from TOML
    if name not in TRUCKS:
        raise CalibrationError(path, f"{where}: unknown truck; expected a or b")
    if not isinstance(values, dict) or set(values) != set(_KEYS):
        raise CalibrationError(path, f"{where}: expected {', '.join(_KEYS)}, and nothing else")
    for key, value in values.items():
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise CalibrationError(path, f"{where}.{key}: {value!r}; expected metres")
    try:
        return Truck(**values)
    except ParameterError as error:
        raise CalibrationError(path, f"{where}.{error}") from error
