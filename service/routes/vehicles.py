"""Vehicles: parameters, their history, and exports in the words of others."""

from __future__ import annotations

import re
from dataclasses import asdict
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Query, Request
from fastapi import Path as PathParameter
from fastapi.responses import PlainTextResponse, Response
from pydantic import BaseModel
from sqlalchemy.orm import Session as Db
from starlette.concurrency import run_in_threadpool

from calib.exports import ros2_yaml, vda5050_json
from service.errors import ChangedError, MediaProblem, ValueProblem
from service.once import Answer, Operating, Reading
from service.problems import documented
from service.routes.common import ALWAYS, IfMatch, condition, etag
from service.store import vehicles
from service.store.tables import VehicleRow
from service.umbmark.models import NAME, Name, TruckSizes
from vehicle.file import parse_vehicle
from vehicle.parameters import TruckName, VehicleParameters

router = APIRouter(prefix="/v1/vehicles", tags=["vehicles"], responses=ALWAYS)
Robot = Annotated[Name, PathParameter(description="name of the vehicle")]
TOML = ("application/toml", "text/plain", "text/x-toml")
TEXTS: dict[str, Any] = {
    "application/toml": {"schema": {"type": "string"}},
    "application/yaml": {},
    "application/json": {"schema": {"type": "object"}},
}
BODY = {"requestBody": {"required": True, "content": {"application/toml": {"schema": {"type": "string"}}}}}


class Vehicle(BaseModel):
    """A version of a vehicle's parameters."""

    name: str
    version: int
    created: float
    origin: str
    trucks: dict[TruckName, TruckSizes]
    link_length: float | None
    toml: str | None = None


def view(row: VehicleRow, *, whole: bool = True) -> Vehicle:
    """Return a version as clients see it; the text of the file only where `whole`."""
    robot = vehicles.parameters(row)
    return Vehicle(
        name=row.name,
        version=row.version,
        created=row.created,
        origin=row.origin,
        trucks={name: TruckSizes(**asdict(truck)) for name, truck in robot.trucks.items()},
        link_length=None if robot.linkage is None else robot.linkage.length,
        toml=row.toml if whole else None,
    )


@router.get("", operation_id="listVehicles", response_model=list[Vehicle])
def every(call: Reading) -> list[Vehicle]:
    """Return the newest version of every vehicle."""
    with call.parts.database.reading() as db:
        return [view(row, whole=False) for row in vehicles.every(db)]


@router.post(
    "",
    operation_id="createVehicle",
    status_code=201,
    response_model=Vehicle,
    responses=documented(415),
    openapi_extra=BODY,
)
async def create(request: Request, call: Operating) -> Response:
    """Add a vehicle by the text of its vehicle.toml."""
    content = await request.body()
    robot = _robot(request, content)

    def act(db: Db) -> Answer:
        row = vehicles.create(db, robot, "sent")
        return Answer(view(row), 201, {"Location": f"{router.prefix}/{row.name}", "ETag": etag(row.version)})

    return await run_in_threadpool(call.once, content, act)


@router.get("/{name}", operation_id="getVehicle", response_model=Vehicle, responses=documented(404))
def one(name: Robot, call: Reading, response: Response) -> Vehicle:
    """Return the newest version of a vehicle."""
    with call.parts.database.reading() as db:
        row = vehicles.newest(db, name)
    response.headers["ETag"] = etag(row.version)
    return view(row)


@router.put(
    "/{name}",
    operation_id="changeVehicle",
    response_model=Vehicle,
    responses=documented(404, 412, 415, 428),
    openapi_extra=BODY,
)
async def change(name: Robot, request: Request, call: Operating, if_match: IfMatch) -> Response:
    """Add a version of a vehicle; the former ones stay."""
    wanted = condition(if_match)
    content = await request.body()
    robot = _robot(request, content)
    if robot.name != name:
        raise ValueProblem("body.name", f"{robot.name!r}; expected {name!r}, the name in the path")
    if wanted is not None and not (wanted.isascii() and wanted.isdigit()):
        raise ChangedError(f"If-Match {wanted!r} is no version of a vehicle; GET it for its ETag")

    def act(db: Db) -> Answer:
        row = vehicles.replace(db, robot, "sent", None if wanted is None else int(wanted))
        return Answer(view(row), 200, {"ETag": etag(row.version)})

    answer = await run_in_threadpool(call.once, content, act)
    if name == call.parts.vehicle:
        call.parts.live.reload()
    return answer


def _robot(request: Request, content: bytes) -> VehicleParameters:
    kind = request.headers.get("content-type", "application/toml").partition(";")[0].strip().lower()
    if kind not in TOML:
        raise MediaProblem(f"content type {kind!r}; expected application/toml, the text of a vehicle.toml")
    try:
        robot = parse_vehicle(content.decode(), "vehicle.toml as it was sent")
    except UnicodeDecodeError as error:
        raise ValueProblem("body", f"not UTF-8: {error}") from error
    if re.fullmatch(NAME, robot.name) is None:
        raise ValueProblem("body.name", f"{robot.name[:120]!r}; expected 1 to 100 characters, no slash")
    return robot


@router.get(
    "/{name}/versions", operation_id="listVersions", response_model=list[Vehicle], responses=documented(404)
)
def history(name: Robot, call: Reading) -> list[Vehicle]:
    """Return all versions of a vehicle, newest first."""
    with call.parts.database.reading() as db:
        return [view(row, whole=False) for row in vehicles.versions(db, name)]


@router.get(
    "/{name}/versions/{version}",
    operation_id="getVersion",
    response_model=Vehicle,
    responses=documented(404),
)
def former(
    name: Robot, version: Annotated[int, PathParameter(ge=1, le=1_000_000_000)], call: Reading
) -> Vehicle:
    """Return one version of a vehicle."""
    with call.parts.database.reading() as db:
        return view(vehicles.version(db, name, version))


@router.get(
    "/{name}/exports/{format}",
    operation_id="exportVehicle",
    response_class=Response,
    responses={**documented(404), 200: {"content": TEXTS}},
)
def export(
    name: Robot,
    format: Literal["toml", "ros2", "vda5050"],  # noqa: A002  # the word in the path
    call: Reading,
    wheel_width: Annotated[float, Query(gt=0.0, lt=1.0, allow_inf_nan=False, description="[m]")] = 0.04,
) -> Response:
    """Return the parameters where users type them: vehicle.toml, ROS 2, or VDA 5050's wheelDefinitions."""
    with call.parts.database.reading() as db:
        last = vehicles.parameters(vehicles.newest(db, name))
        first = vehicles.parameters(vehicles.version(db, name, 1))
        text = vehicles.newest(db, name).toml
    if format == "ros2":
        both = {truck: (first.trucks.get(truck, size), size) for truck, size in last.trucks.items()}
        return PlainTextResponse(ros2_yaml(both), media_type="application/yaml")
    if format == "vda5050":
        return Response(vda5050_json(last, wheel_width), media_type="application/json")
    return PlainTextResponse(text, media_type="application/toml")
