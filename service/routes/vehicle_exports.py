"""The parameters of a vehicle over REST, in the formats of other tools."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from fastapi import APIRouter, Query
from fastapi.responses import PlainTextResponse, Response

from omnimate.calib.exports import ros2_yaml, vda5050_json
from omnimate.service.calls import Reading
from omnimate.service.problems import documented
from omnimate.service.routes.common import ALWAYS
from omnimate.service.routes.vehicles import PREFIX, VehicleName
from omnimate.service.store import vehicles

router = APIRouter(prefix=PREFIX, tags=["vehicles"], responses=ALWAYS)
EXPORT_TYPES: dict[str, Any] = {
    "application/toml": {"schema": {"type": "string"}},
    "application/yaml": {},
    "application/json": {"schema": {"type": "object"}},
}


@router.get(
    "/{name}/exports/{format}",
    operation_id="exportVehicle",
    response_class=Response,
    responses={**documented(404), 200: {"content": EXPORT_TYPES}},
)
def export(
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
