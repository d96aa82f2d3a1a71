"""`vehicle.toml`: read with strict checks, and written whole or not at all."""

from __future__ import annotations

import tomllib
from dataclasses import MISSING, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import tomli_w

from vehicle.atomic import write_text
from vehicle.errors import VehicleFileError
from vehicle.parameters import (
    TRUCKS,
    Bus,
    Drive,
    Encoder,
    Limits,
    Linkage,
    ParameterError,
    Truck,
    VehicleParameters,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

T = TypeVar("T")

_TABLES = ("name", "truck", "linkage", "bus", "encoder", "drive", "limits")
_TYPES: dict[str, tuple[tuple[type, ...], str]] = {
    "float": ((int, float), "a number"),
    "float | None": ((int, float), "a number"),
    "int": ((int,), "a whole number"),
    "int | None": ((int,), "a whole number"),
    "bool": ((bool,), "true or false"),
    "str": ((str,), "text"),
    "Channel": ((str,), "text"),
    "Profile": ((str,), "text"),
}


def load_vehicle(path: Path | str) -> VehicleParameters:
    """Return the robot that a `vehicle.toml` describes.

    Raises:
        VehicleFileError: it is absent, no TOML, or describes no possible robot; the error names the key.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise VehicleFileError(path, "(file)", f"cannot be read: {error}") from error
    return parse_vehicle(text, path)


def parse_vehicle(text: str, source: Path | str = "vehicle.toml") -> VehicleParameters:
    """Return the robot that the text of a `vehicle.toml` describes; `source` is named in errors.

    Raises:
        VehicleFileError: as `load_vehicle`.
    """
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise VehicleFileError(source, "(syntax)", f"not TOML: {error}") from error
    return _Reader(source).vehicle(document)


def save_vehicle(vehicle: VehicleParameters, path: Path | str) -> None:
    """Write a `vehicle.toml`; a crash leaves the former file or the new one, never a part."""
    write_text(Path(path), format_vehicle(vehicle))


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


def _table(item: Any) -> dict[str, Any]:  # noqa: ANN401  # any of the dataclasses above
    """Return a dataclass as a TOML table without what is unset or at its default."""
    table = {field.name: getattr(item, field.name) for field in fields(item)}
    defaults = {field.name: field.default for field in fields(item)}
    always = isinstance(item, Limits)
    return {key: value for key, value in table.items() if always or value != defaults[key]}


class _Reader:
    """Turns TOML tables into dataclasses and every problem into an error with its place."""

    def __init__(self, source: Path | str) -> None:
        self.source = source

    def vehicle(self, document: Mapping[str, Any]) -> VehicleParameters:
        for key in document:
            if key not in _TABLES:
                raise VehicleFileError(self.source, key, f"unknown key; expected one of {', '.join(_TABLES)}")
        name = document.get("name", "unnamed")
        if not isinstance(name, str):
            raise VehicleFileError(self.source, "name", f"{name!r}; expected text")
        trucks = self._mapping(document, "truck")
        for key in trucks:
            if key not in TRUCKS:
                raise VehicleFileError(self.source, f"truck.{key}", "unknown truck; expected a or b")
        try:
            return VehicleParameters(
                name=name,
                trucks={
                    key: self.table(Truck, trucks[key], f"truck.{key}") for key in TRUCKS if key in trucks
                },
                linkage=(
                    self.table(Linkage, document["linkage"], "linkage") if "linkage" in document else None
                ),
                bus=self.table(Bus, self._mapping(document, "bus"), "bus"),
                encoders=self._list(Encoder, document, "encoder"),
                drives=self._list(Drive, document, "drive"),
                limits=self.table(Limits, document.get("limits", {}), "limits"),
            )
        except ParameterError as error:
            raise VehicleFileError(self.source, error.key, error.problem) from error

    def _mapping(self, document: Mapping[str, Any], key: str) -> Mapping[str, Any]:
        value = document.get(key)
        if not isinstance(value, dict):
            raise VehicleFileError(self.source, key, "missing; expected a table")
        return value

    def _list(self, kind: type[T], document: Mapping[str, Any], key: str) -> tuple[T, ...]:
        value = document.get(key, [])
        if not isinstance(value, list):
            raise VehicleFileError(self.source, key, f"expected a list of tables: [[{key}]]")
        return tuple(self.table(kind, table, f"{key}[{index}]") for index, table in enumerate(value))

    def table(self, kind: type[T], table: Any, where: str) -> T:  # noqa: ANN401  # from TOML
        """Return one dataclass from one table, every key known, typed and possible."""
        if not isinstance(table, dict):
            raise VehicleFileError(self.source, where, f"{table!r}; expected a table")
        known = {field.name: field for field in fields(kind)}  # type: ignore[arg-type]  # dataclasses all
        for key in table:
            if key not in known:
                raise VehicleFileError(
                    self.source, f"{where}.{key}", f"unknown key; expected one of {', '.join(known)}"
                )
        for key, field in known.items():
            if key in table:
                self._check_type(table[key], str(field.type), f"{where}.{key}")
            elif field.default is MISSING:
                raise VehicleFileError(self.source, f"{where}.{key}", "missing")
        try:
            return kind(**table)
        except ParameterError as error:
            raise VehicleFileError(self.source, f"{where}.{error.key}", error.problem) from error

    def _check_type(self, value: Any, annotation: str, where: str) -> None:  # noqa: ANN401  # from TOML
        types, words = _TYPES[annotation]
        if not isinstance(value, types) or (isinstance(value, bool) and bool not in types):
            raise VehicleFileError(self.source, where, f"{value!r}; expected {words}")
