"""The robot: what is on the bus, where it is, the stream, and the stop that every key may call."""

from __future__ import annotations

import queue
from collections.abc import Iterator
from dataclasses import asdict
from functools import lru_cache
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Query
from fastapi.responses import PlainTextResponse, Response, StreamingResponse
from pydantic import BaseModel

from driver.report import DriverReport
from service.once import Reading
from service.parts import Parts
from service.robot.faults import open_rmf, vda5050
from service.robot.live import nodes_event
from service.routes.common import ALWAYS, Done

router = APIRouter(prefix="/v1", tags=["robot"], responses=ALWAYS)
STREAM = {"text/event-stream": {"schema": {"type": "string"}}}
EVENTS: dict[int | str, dict[str, Any]] = {200: {"content": STREAM}}
SILENCE = 0.5  # [s] between two looks whether a reader of frames is still there


class Robot(BaseModel):
    """The robot on the bus."""

    vehicle: str
    mode: Literal["simulated", "bus"]
    problem: str | None
    driving: str | None
    samples: int
    incomplete: int
    state: dict[str, Any]


class Bus(BaseModel):
    """The bus, as the driver saw it within the last second."""

    syncs: int
    skipped: int
    nodes: list[dict[str, Any]]
    events: list[dict[str, Any]]
    strangers: list[dict[str, Any]]


@router.get("/robot", operation_id="getRobot", response_model=Robot)
async def robot(call: Reading) -> Robot:
    """Return what is on the bus, whether it drives and for whom, where it is."""
    live = call.parts.live
    samples, incomplete = live.samples
    return Robot(
        vehicle=call.parts.vehicle,
        mode="simulated" if live.mode == "simulated" else "bus",
        problem=live.problem,
        driving=live.driving,
        samples=samples,
        incomplete=incomplete,
        state=live.state,
    )


@router.post("/robot/stop", operation_id="stopRobot", response_model=Done)
async def stop(call: Reading) -> Done:
    """Stop the wheels at the next sample, whoever asks; a session that is driven is interrupted."""
    call.parts.live.halt("somebody pressed stop")
    return Done(done="the robot stops")


@router.get("/robot/stream", operation_id="streamRobot", response_class=StreamingResponse, responses=EVENTS)
async def stream(call: Reading) -> StreamingResponse:
    """Stream where the robot is and what happens, as server-sent events."""
    return StreamingResponse(
        call.parts.hub.listen(),
        media_type="text/event-stream",
        headers={"Cache-Control": "no-cache", "X-Accel-Buffering": "no"},
    )


@router.get("/robot/errors", operation_id="getErrors", response_model=dict[str, Any])
async def errors(call: Reading, format: Literal["vda5050", "open-rmf"] = "vda5050") -> dict[str, Any]:  # noqa: A002
    """Return what is wrong now, as VDA 5050 `errors` or Open-RMF `issues`."""
    live = call.parts.live
    words = vda5050 if format == "vda5050" else open_rmf
    return words(live.problem, live.report)


@router.get("/bus", operation_id="getBus", response_model=Bus)
async def bus(call: Reading) -> Response:
    """Return nodes, counters, and what has happened."""
    return Response(_bus(call.parts.live.report), media_type="application/json")


@lru_cache(maxsize=1)
def _bus(report: DriverReport | None) -> bytes:
    if report is None:
        known = Bus(syncs=0, skipped=0, nodes=[], events=[], strangers=[])
    else:
        known = Bus(
            syncs=report.syncs,
            skipped=report.skipped,
            nodes=nodes_event(report)["nodes"],
            events=[asdict(one) for one in report.events],
            strangers=[{"identifier": key, "what": what, "frames": n} for key, what, n in report.strangers],
        )
    return known.model_dump_json().encode()


@router.get(
    "/bus/frames",
    operation_id="streamFrames",
    response_class=PlainTextResponse,
    responses={200: {"content": {"text/plain": {"schema": {"type": "string"}}}}},
)
def frames(
    call: Reading, count: Annotated[int | None, Query(ge=1, le=1_000_000, description="ends it")] = None
) -> StreamingResponse:
    """Stream the frames of the bus as `candump -L` prints them."""
    return StreamingResponse(_lines(call.parts, count), media_type="text/plain")


def _lines(parts: Parts, count: int | None) -> Iterator[str]:
    with parts.live.tap.reader() as reader:
        sent = 0
        while count is None or sent < count:
            try:
                yield reader.get(timeout=SILENCE) + "\n"
                sent += 1
            except queue.Empty:
                if parts.hub.is_closed or parts.live.problem is not None:
                    return
