"""The factsheet: what its manufacturer states of a robot, with the calibrated wheels."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from omnimate.calib.exports import vda5050_wheels
from omnimate.service.errors import ServiceError

if TYPE_CHECKING:
    from pathlib import Path

    from omnimate.vehicle.parameters import VehicleParameters

# What VDA 5050 2.1 requires of a factsheet in addition to its header.
REQUIRED = {
    "typeSpecification": (
        *("seriesName", "agvKinematic", "agvClass", "maxLoadMass", "localizationTypes", "navigationTypes"),
    ),
    "physicalParameters": (
        *("speedMin", "speedMax", "accelerationMax", "decelerationMax"),
        *("heightMin", "heightMax", "width", "length"),
    ),
    "protocolLimits": ("maxStringLens", "maxArrayLens", "timing"),
    "protocolFeatures": ("optionalParameters", "agvActions"),
    "agvGeometry": (),
    "loadSpecification": (),
}


class FactsheetError(ServiceError):
    """A factsheet that cannot be used."""

    def __init__(self, path: Path, problem: str) -> None:
        super().__init__(f"{path}: {problem}")
        self.path = path


@dataclass(frozen=True, slots=True)
class Factsheet:
    """A robot's factsheet as its manufacturer states it."""

    manufacturer: str  # a part of the robot's topics, as the serial number
    serial: str
    wheel_width: float  # [m]
    content: dict[str, Any]  # all of it but the header

    def with_wheels(self, vehicle: VehicleParameters) -> dict[str, Any]:
        """Return the content with the wheels of a calibrated vehicle."""
        wheels = vda5050_wheels(vehicle, self.wheel_width)
        return self.content | {"agvGeometry": self.content["agvGeometry"] | {"wheelDefinitions": wheels}}


def load_factsheet(path: Path) -> Factsheet:
    """Return the factsheet in a JSON file; FactsheetError where it lacks what VDA 5050 requires."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise FactsheetError(path, f"cannot be read as JSON: {error}") from error
    if not isinstance(content, dict):
        raise FactsheetError(path, "expected a JSON object, the factsheet of VDA 5050")
    for name in ("manufacturer", "serialNumber"):
        text = content.get(name)
        if not isinstance(text, str) or not text or set(text) & set("+#/$"):
            raise FactsheetError(path, f"{name}: expected a text without '+', '#', '/', '$'")
    for part, fields in REQUIRED.items():
        if not isinstance(content.get(part), dict):
            raise FactsheetError(path, f"{part} is missing, which VDA 5050 requires")
        missing = [field for field in fields if field not in content[part]]
        if missing:
            raise FactsheetError(path, f"{part}: {', '.join(missing)} missing, which VDA 5050 requires")
    rest = {name: content[name] for name in content if name not in _HEADER}
    return Factsheet(content["manufacturer"], content["serialNumber"], _wheel_width(path, content), rest)


_HEADER = {"headerId", "timestamp", "version", "manufacturer", "serialNumber"}


def _wheel_width(path: Path, content: dict[str, Any]) -> float:
    """Return the width of the first wheel, which a calibration does not give."""
    wheels = content["agvGeometry"].get("wheelDefinitions")
    width = wheels[0].get("width") if isinstance(wheels, list) and wheels else None
    if not isinstance(width, (int, float)) or not 0.0 < width < 1.0:
        raise FactsheetError(path, "agvGeometry.wheelDefinitions: expected a wheel with its width in metres")
    return float(width)
