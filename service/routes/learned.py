"""What the filter has learned of a robot, over REST: live and of a recording, and as a vehicle's version."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Annotated, Literal

from fastapi import APIRouter, Query
from fastapi.responses import Response
from pydantic import Field

from omnimate.calib.linkage.learned import advice_of, learned_values, learned_vehicle
from omnimate.service.calls import Answer, Call, Operating, Reading
from omnimate.service.errors import ModifiedError, NotFoundError, StateError, UnavailableError
from omnimate.service.problems import documented
from omnimate.service.routes.common import ALWAYS, IfMatch, etag, expected_version
from omnimate.service.routes.recordings import RecordingId
from omnimate.service.routes.vehicles import Vehicle, vehicle_view
from omnimate.service.store import vehicles
from omnimate.service.store.recordings import learned_by
from omnimate.service.store.tables import RecordingRow, find_row
from omnimate.service.umbmark.models import Advice, RowModel

if TYPE_CHECKING:
    from collections.abc import Callable

    from sqlalchemy.orm import Session as Db

    from omnimate.ipec.tracker import Learned as FilterLearned
    from omnimate.service.store.tables import VehicleRow
    from omnimate.vehicle.parameters import VehicleParameters


class LearnedValue(RowModel):
    """A value of the robot that the filter has learned."""

    name: str
    unit: Literal["m", "s", "rad"]
    described: float = Field(description="The value of the vehicle's version.")
    value: float = Field(description="The value that was learned.")
    sigma: float = Field(description="Its standard deviation.")


class Probable(RowModel):
    """What is probably wrong with a robot, and its probability."""

    name: str
    probability: float


class Learned(RowModel):
    """What the filter has learned of a robot from its encoders alone."""

    vehicle: str
    vehicle_version: int | None = Field(
        description="The version by which the robot drove; null where the service does not have it."
    )
    values: list[LearnedValue]
    suspects: list[Probable] = Field(description="What is probably wrong in the vehicle's version.")
    undecided: list[Probable] = Field(description="What may be wrong or not; accepting leaves it as it is.")
    misread: list[Probable] = Field(description="What reads more than an angle and a bias.")
    untold: list[str] = Field(description="What this drive does not identify.")
    advice: list[Advice]


def _learned_view(call: Call, learned: FilterLearned) -> Learned:
    vehicle, slow, findings = learned
    with call.components.database.reading() as db:
        described = _version_of(db, vehicle)
    return Learned.of(
        findings,
        vehicle=vehicle.name,
        vehicle_version=None if described is None else described.version,
        values=learned_values(vehicle, slow),
        suspects=[Probable(name=name, probability=value) for name, value in findings.suspects],
        undecided=[Probable(name=name, probability=value) for name, value in findings.undecided],
        misread=[Probable(name=name, probability=value) for name, value in findings.misread],
        advice=advice_of(findings),
    )


def _version_of(db: Db, vehicle: VehicleParameters) -> VehicleRow | None:
    """Return the newest version with the same sizes and encoders; None where there is none."""
    try:
        rows = vehicles.versions(db, vehicle.name)
    except NotFoundError:
        return None
    return next((row for row in rows if _measures(vehicles.parameters_of(row)) == _measures(vehicle)), None)


def _measures(vehicle: VehicleParameters) -> tuple[object, ...]:
    """Return what decides how counts become a pose; a recording has its EDS files elsewhere."""
    return vehicle.trucks, vehicle.linkage, [replace(encoder, eds=None) for encoder in vehicle.encoders]


router = APIRouter(prefix="/v1", tags=["learned"], responses=ALWAYS)
Uncalibrated = Annotated[
    bool, Query(description="Whether the vehicle holds nominal values, so that more of them may be wrong.")
]


@router.get("/robot/learned")
def get_learned(call: Reading) -> Learned:
    """Return what the filter has learned of the robot on the bus since its parameters were taken."""
    return _learned_view(call, _learned_live(call))


@router.post("/robot/learned/accept", response_model=Vehicle, responses=documented(412, 428))
def accept_learned(call: Operating, if_match: IfMatch) -> Response:
    """Make what was learned of the robot on the bus the newest version of its vehicle."""
    return _accept(call, if_match, "learned on the way", lambda: _learned_live(call))


@router.get("/recordings/{recording_id}/learned")
def get_learned_of_recording(
    recording_id: RecordingId, call: Reading, uncalibrated: Uncalibrated = False
) -> Learned:
    """Return what the filter has learned of its robot by the end of a recording."""
    return _learned_view(call, _learned_by(call, recording_id, uncalibrated=uncalibrated))


@router.post(
    "/recordings/{recording_id}/learned/accept", response_model=Vehicle, responses=documented(412, 428)
)
def accept_learned_of_recording(
    recording_id: RecordingId, call: Operating, if_match: IfMatch, uncalibrated: Uncalibrated = False
) -> Response:
    """Make what the filter has learned by the end of a recording the newest version of its vehicle."""
    return _accept(
        call,
        if_match,
        f"learned from recording {recording_id}",
        lambda: _learned_by(call, recording_id, uncalibrated=uncalibrated),
    )


def _accept(call: Call, if_match: str, origin: str, learn: Callable[[], FilterLearned]) -> Response:
    """Make what was learned the newest version of its vehicle, except what is undecided.

    The robot on the bus drives by it from then on.
    """
    expected, accepted = expected_version(if_match), []

    def act(db: Db, learned: FilterLearned) -> Answer:
        vehicle, slow, findings = learned
        described = _version_of(db, vehicle)
        if described is None:
            raise StateError(
                f"vehicle {vehicle.name!r} has no version with the parameters by which the robot drove; "
                "POST or PUT its vehicle.toml, then try again"
            )
        if expected is not None and expected != str(described.version):
            raise ModifiedError(
                f"the robot drove by version {described.version} of vehicle {vehicle.name!r}, not "
                f"{expected}; look at what was learned again"
            )
        corrected = learned_vehicle(vehicles.parameters_of(described), slow, findings)
        made = vehicles.Origin(origin, call.caller.key_name)
        row = vehicles.add_version(db, corrected, made, described.version)
        accepted.append(row.name)
        return Answer(vehicle_view(row), 200, {"ETag": etag(row.version)})

    response = call.compute_and_change(None, learn, act)
    if call.components.vehicle in accepted:
        call.components.robot.reload()
    return response


def _learned_live(call: Call) -> FilterLearned:
    """Return the robot on the bus by which its tracker drove, and what it has learned and found."""
    learned = call.components.robot.learned()
    if learned is None:
        raise UnavailableError(
            "the filter does not follow the robot: it needs two trucks, a linkage that is read, and half a "
            "minute after the first start on a machine"
        )
    return learned


def _learned_by(call: Call, recording_id: str, *, uncalibrated: bool) -> FilterLearned:
    """Return what the filter has learned by the end of a recording of the database."""
    with call.components.database.reading() as db:
        row = find_row(db, RecordingRow, recording_id)
    return call.components.recordings.read(row, partial(learned_by, uncalibrated=uncalibrated))
