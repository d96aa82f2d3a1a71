"""The parameters of vehicles over REST: versions, and the formats of other tools."""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal
from urllib.parse import quote

from fastapi import APIRouter, Query, Request
from fastapi import Path as PathParameter
from fastapi.responses import PlainTextResponse, Response
from pydantic import Field
from sqlalchemy.orm import Session as Db
from starlette.concurrency import run_in_threadpool

from omnimate.calib.exports import ros2_yaml, vda5050_json
from omnimate.service.calls import Answer, Operating, Reading
from omnimate.service.errors import InvalidValueError, ModifiedError
from omnimate.service.problems import documented
from omnimate.service.routes.common import ALWAYS, IfMatch, etag, expected_version, require_type
from omnimate.service.store import vehicles
from omnimate.service.store.tables import VehicleRow
from omnimate.service.umbmark.models import Name, RowModel, TruckSizes
from omnimate.vehicle.errors import describe_read_error
from omnimate.vehicle.file import parse_vehicle
from omnimate.vehicle.parameters import TruckName, VehicleParameters

PREFIX = "/v1/vehicles"
router = APIRouter(prefix=PREFIX, tags=["vehicles"], responses=ALWAYS)
VehicleName = Annotated[Name, PathParameter(description="The name of the vehicle.")]
TOML_TYPES = ("application/toml", "text/plain", "text/x-toml")
BODY = {"requestBody": {"required": True, "content": {"application/toml": {"schema": {"type": "string"}}}}}


class Vehicle(RowModel):
    """A version of a vehicle's parameters."""

    name: str
    version: int
    created: float
    origin: str = Field(description="Where the version comes from, in words.")
    session: str | None = Field(
        description="The id of the UMBmark session whose result it is; null for another origin."
    )
    made_by: str | None = Field(description="The name of the key with which it was made; null without a key.")
    trucks: dict[TruckName, TruckSizes]
    link_length: float | None
    toml: str | None = None


def vehicle_view(row: VehicleRow, *, whole: bool = True) -> Vehicle:
    """Return a version as clients see it; `whole` includes the text of its vehicle.toml."""
    parameters = vehicles.parameters_of(row)
    length = None if parameters.linkage is None else parameters.linkage.length
    toml = row.toml if whole else None
    return Vehicle.of(row, trucks=dict(parameters.trucks), link_length=length, toml=toml)


def headers_of(row: VehicleRow) -> dict[str, str]:
    """Return where a version just made is, and its ETag; a name may hold characters that no header takes."""
    return {"Location": f"{PREFIX}/{quote(row.name, safe='')}", "ETag": etag(row.version)}


@router.get("")
def list_vehicles(call: Reading) -> list[Vehicle]:
    """Return the newest version of every vehicle."""
    with call.components.database.reading() as db:
        return [vehicle_view(row, whole=False) for row in vehicles.newest_of_all(db)]


@router.post("", status_code=201, response_model=Vehicle, openapi_extra=BODY)
async def create_vehicle(request: Request, call: Operating) -> Response:
    """Add a vehicle. The body is the text of its vehicle.toml."""
    content = await request.body()
    vehicle, text = _parsed(request, content)

    def act(db: Db) -> Answer:
        row = vehicles.create(db, vehicle, vehicles.Origin("sent", call.caller.key_name), text)
        return Answer(vehicle_view(row), 201, headers_of(row))

    return await run_in_threadpool(call.change, content, act)


@router.get("/{name}")
def get_vehicle(name: VehicleName, call: Reading, response: Response) -> Vehicle:
    """Return the newest version of a vehicle."""
    with call.components.database.reading() as db:
        row = vehicles.newest(db, name)
    response.headers["ETag"] = etag(row.version)
    return vehicle_view(row)


@router.put("/{name}", response_model=Vehicle, responses=documented(412, 428), openapi_extra=BODY)
async def change_vehicle(name: VehicleName, request: Request, call: Operating, if_match: IfMatch) -> Response:
    """Add a version of a vehicle. The former versions stay."""
    expected = expected_version(if_match)
    content = await request.body()
    vehicle, text = _parsed(request, content)
    if vehicle.name != name:
        raise InvalidValueError("body.name", f"{vehicle.name!r}; expected {name!r}, the name in the path")
    if expected is not None and re.fullmatch("[0-9]{1,9}", expected) is None:
        raise ModifiedError(f"If-Match {expected!r} is no version of a vehicle; GET the vehicle for its ETag")

    def act(db: Db) -> Answer:
        version = None if expected is None else int(expected)
        origin = vehicles.Origin("sent", call.caller.key_name)
        row = vehicles.add_version(db, vehicle, origin, version, text)
        return Answer(vehicle_view(row), 200, {"ETag": etag(row.version)})

    response = await run_in_threadpool(call.change, content, act)
    if name == call.components.vehicle:
        call.components.robot.reload()
    return response


def _parsed(request: Request, content: bytes) -> tuple[VehicleParameters, str]:
    """Return the vehicle of a request's body, and the body, the text of a vehicle.toml."""
    require_type(request, TOML_TYPES, "the text of a vehicle.toml")
    try:
        text = content.decode()
        vehicle = parse_vehicle(text, "vehicle.toml as it was sent")
    except UnicodeDecodeError as error:
        raise InvalidValueError("body", describe_read_error(error)) from error
    vehicles.require_name(vehicle, "body.name")
    return vehicle, text


@router.get("/{name}/versions")
def list_versions(name: VehicleName, call: Reading) -> list[Vehicle]:
    """Return all versions of a vehicle, newest first."""
    with call.components.database.reading() as db:
        return [vehicle_view(row, whole=False) for row in vehicles.versions(db, name)]


@router.get("/{name}/versions/{version}")
def get_version(
    name: VehicleName, version: Annotated[int, PathParameter(ge=1, le=1_000_000_000)], call: Reading
) -> Vehicle:
    """Return one version of a vehicle."""
    with call.components.database.reading() as db:
        return vehicle_view(vehicles.version(db, name, version))


EXPORT_TYPES: dict[str, Any] = {
    "application/toml": {"schema": {"type": "string"}},
    "application/yaml": {},
    "application/json": {"schema": {"type": "object"}},
}


@router.get("/{name}/exports/{format}", response_class=Response, responses={200: {"content": EXPORT_TYPES}})
def export_vehicle(
    name: VehicleName,
    format: Literal["toml", "ros2", "vda5050"],  # noqa: A002  # the word in the path
    call: Reading,
    wheel_width: Annotated[
        float,
        Query(
            gt=0.0,
            lt=1.0,
            allow_inf_nan=False,
            description="The width of the wheels in the VDA 5050 export [m].",
        ),
    ] = 0.04,
) -> Response:
    """Return the parameters as vehicle.toml, as ROS 2 parameters, or as VDA 5050 wheelDefinitions."""
    with call.components.database.reading() as db:
        row = vehicles.newest(db, name)
        last = vehicles.parameters_of(row)
        first = vehicles.parameters_of(vehicles.version(db, name, 1))
    if format == "ros2":
        both = {truck: (first.trucks.get(truck, size), size) for truck, size in last.trucks.items()}
        return PlainTextResponse(ros2_yaml(both), media_type="application/yaml")
    if format == "vda5050":
        return Response(vda5050_json(last, wheel_width), media_type="application/json")
    return PlainTextResponse(row.toml, media_type="application/toml")
