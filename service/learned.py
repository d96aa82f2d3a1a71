"""What the filter has learned of a robot, as clients see it, and as the vehicle's next version."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import BaseModel, Field

from omnimate.calib.linkage.learned import advice_of, learned_values, learned_vehicle
from omnimate.service.errors import ModifiedError, NotFoundError, StateError
from omnimate.service.store import vehicles
from omnimate.service.umbmark.models import Advice

if TYPE_CHECKING:
    from sqlalchemy.orm import Session

    from omnimate.ipec.filter.findings import Findings
    from omnimate.ipec.filter.slow_parameters import SlowParameters
    from omnimate.service.store.tables import VehicleRow
    from omnimate.vehicle.parameters import VehicleParameters


class LearnedValue(BaseModel):
    """A value of the robot that the filter has learned."""

    name: str
    unit: Literal["m", "s", "rad"]
    described: Annotated[float, Field(description="The value of the vehicle's version.")]
    value: Annotated[float, Field(description="The value that was learned.")]
    sigma: Annotated[float, Field(description="Its standard deviation.")]


class Probable(BaseModel):
    """What is probably wrong with a robot, and its probability."""

    name: str
    probability: float


class Learned(BaseModel):
    """What the filter has learned of a robot from its encoders alone."""

    vehicle: str
    vehicle_version: Annotated[
        int | None,
        Field(description="The version by which the robot drove; null where the service does not have it."),
    ]
    values: list[LearnedValue]
    suspects: Annotated[list[Probable], Field(description="What is probably wrong in the vehicle's version.")]
    misread: Annotated[list[Probable], Field(description="What reads more than an angle and a bias.")]
    untold: Annotated[list[str], Field(description="What this drive does not tell.")]
    advice: list[Advice]


def learned_view(db: Session, vehicle: VehicleParameters, slow: SlowParameters, said: Findings) -> Learned:
    """Return what was learned of a vehicle as clients see it."""
    described = _version_of(db, vehicle)
    return Learned(
        vehicle=vehicle.name,
        vehicle_version=None if described is None else described.version,
        values=[LearnedValue(**asdict(value)) for value in learned_values(vehicle, slow)],
        suspects=[Probable(name=name, probability=value) for name, value in said.suspects],
        misread=[Probable(name=name, probability=value) for name, value in said.misread],
        untold=list(said.untold),
        advice=[Advice(**asdict(advice)) for advice in advice_of(said)],
    )


def accept_learned(
    db: Session, vehicle: VehicleParameters, slow: SlowParameters, origin: str, expected: str | None
) -> VehicleRow:
    """Make what was learned of a vehicle its newest version.

    Args:
        db: The open transaction.
        vehicle: The vehicle as the robot drove by it.
        slow: What was learned of it.
        origin: Where it was learned, in words.
        expected: The version that the caller believes to be the newest; None accepts any version.

    Raises:
        StateError: the service has no version with these parameters.
        ModifiedError: the version by which the robot drove is not the expected one, or not the newest.
    """
    described = _version_of(db, vehicle)
    if described is None:
        raise StateError(
            f"vehicle {vehicle.name!r} has no version with the parameters by which the robot drove; "
            "POST or PUT its vehicle.toml, then try again"
        )
    if expected is not None and expected != str(described.version):
        raise ModifiedError(
            f"the robot drove by version {described.version} of vehicle {vehicle.name!r}, not {expected}; "
            "look at what was learned again"
        )
    learned = learned_vehicle(vehicles.parameters_of(described), slow)
    return vehicles.add_version(db, learned, origin, described.version)


def _version_of(db: Session, vehicle: VehicleParameters) -> VehicleRow | None:
    """Return the newest version with the same sizes and encoders; None where there is none."""
    try:
        rows = vehicles.versions(db, vehicle.name)
    except NotFoundError:
        return None
    return next((row for row in rows if _measures(vehicles.parameters_of(row)) == _measures(vehicle)), None)


def _measures(vehicle: VehicleParameters) -> tuple[object, ...]:
    """Return what decides how counts become a pose; a recording has its EDS files elsewhere."""
    return vehicle.trucks, vehicle.linkage, [replace(encoder, eds=None) for encoder in vehicle.encoders]
