"""Reading of `vehicle.toml` with strict checks, and atomic writing."""

from __future__ import annotations

import os
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import tomli_w

from omnimate.vehicle.atomic import write_text
from omnimate.vehicle.errors import TableError, VehicleFileError
from omnimate.vehicle.parameters import (
    TRUCKS,
    Bus,
    Drive,
    Encoder,
    Limits,
    Linkage,
    Truck,
    VehicleParameters,
)
from omnimate.vehicle.tables import dataclass_of, parse_toml, read_toml, value_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

T = TypeVar("T")
Owner = TypeVar("Owner", Encoder, Drive)

_TABLES = ("name", "truck", "linkage", "bus", "encoder", "drive", "limits")


def load_vehicle(path: Path | str) -> VehicleParameters:
    """Return the robot that a `vehicle.toml` describes, with absolute paths of its EDS files.

    Raises:
        VehicleFileError: The file is absent, is not TOML, or describes no possible robot; names the key.
    """
    try:
        vehicle = _vehicle(read_toml(path))
    except TableError as error:
        raise VehicleFileError(path, error.key, error.problem) from error
    folder = Path(path).resolve().parent
    return _with_eds(vehicle, lambda eds: str(folder / eds))


def parse_vehicle(text: str, source: Path | str = "vehicle.toml") -> VehicleParameters:
    """Return the robot that the text of a `vehicle.toml` describes; `source` is named in errors.

    Raises:
        VehicleFileError: The text is not TOML or describes no possible robot; the error names the key.
    """
    try:
        return _vehicle(parse_toml(text))
    except TableError as error:
        raise VehicleFileError(source, error.key, error.problem) from error


def save_vehicle(vehicle: VehicleParameters, path: Path | str) -> None:
    """Write a `vehicle.toml` atomically.

    Absolute paths of EDS files are written relative to the file.
    """
    folder = Path(path).resolve().parent
    write_text(Path(path), format_vehicle(_with_eds(vehicle, lambda eds: _seen_from(folder, eds))))


def format_vehicle(vehicle: VehicleParameters) -> str:
    """Return the text of the `vehicle.toml`; reading it back gives the same robot."""
    document: dict[str, Any] = {
        "name": vehicle.name,
        "truck": {name: _table(truck) for name, truck in sorted(vehicle.trucks.items())},
    }
    if vehicle.linkage is not None:
        document["linkage"] = _table(vehicle.linkage)
    document["bus"] = _table(vehicle.bus)
    if vehicle.limits != Limits():
        document["limits"] = _table(vehicle.limits)
    document["encoder"] = [_table(encoder) for encoder in vehicle.encoders]
    if vehicle.drives:
        document["drive"] = [_table(drive) for drive in vehicle.drives]
    return tomli_w.dumps(document)


def _with_eds(vehicle: VehicleParameters, path: Callable[[str], str]) -> VehicleParameters:
    """Return the same robot with other paths of its EDS files."""

    def moved(owner: Owner) -> Owner:
        return owner if owner.eds is None else replace(owner, eds=path(owner.eds))

    if not vehicle.eds_files:
        return vehicle
    return replace(
        vehicle,
        encoders=tuple(moved(encoder) for encoder in vehicle.encoders),
        drives=tuple(moved(drive) for drive in vehicle.drives),
    )


def _seen_from(folder: Path, path: str) -> str:
    if not Path(path).is_absolute() or Path(path).drive != folder.drive:
        return path
    return Path(os.path.relpath(path, folder)).as_posix()


def _table(item: Any) -> dict[str, Any]:  # noqa: ANN401  # any of the dataclasses above
    """Return a dataclass as a TOML table without what is unset or at its default."""
    table = {field.name: getattr(item, field.name) for field in fields(item)}
    defaults = {field.name: field.default for field in fields(item)}
    always = isinstance(item, Limits)
    return {key: value for key, value in table.items() if always or value != defaults[key]}


def _vehicle(document: Mapping[str, Any]) -> VehicleParameters:
    for key in document:
        if key not in _TABLES:
            raise TableError(key, f"unknown key; expected one of {', '.join(_TABLES)}")
    trucks = _mapping(document, "truck")
    for key in trucks:
        if key not in TRUCKS:
            raise TableError(f"truck.{key}", "unknown truck; expected a or b")
    return VehicleParameters(
        name=value_of("str", document.get("name", "unnamed"), "name"),
        trucks={
            name: dataclass_of(Truck, trucks[name], f"truck.{name}") for name in TRUCKS if name in trucks
        },
        linkage=dataclass_of(Linkage, document["linkage"], "linkage") if "linkage" in document else None,
        bus=dataclass_of(Bus, _mapping(document, "bus"), "bus"),
        encoders=_list(Encoder, document, "encoder"),
        drives=_list(Drive, document, "drive"),
        limits=dataclass_of(Limits, document.get("limits", {}), "limits"),
    )


def _mapping(document: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    value = document.get(key)
    if not isinstance(value, dict):
        given = repr(value) if key in document else "missing"
        raise TableError(key, f"{given}; expected a table [{key}]")
    return value


def _list(kind: type[T], document: Mapping[str, Any], key: str) -> tuple[T, ...]:
    value = document.get(key, [])
    if not isinstance(value, list):
        raise TableError(key, f"expected a list of tables: [[{key}]]")
    return tuple(dataclass_of(kind, table, f"{key}[{index}]") for index, table in enumerate(value))
