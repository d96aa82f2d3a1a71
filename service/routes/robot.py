"""The robot over REST: its state, its bus, the event stream, and the stop, which every key may call."""

from __future__ import annotations

import asyncio
import queue
import time
from collections.abc import AsyncGenerator, AsyncIterator, Iterator
from contextlib import aclosing
from dataclasses import asdict
from functools import lru_cache
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Query
from fastapi.responses import PlainTextResponse, Response, StreamingResponse
from pydantic import BaseModel

from omnimate.driver.robot.report import DriverReport
from omnimate.service.calls import Call, Reading, Stopping
from omnimate.service.robot.faults import open_rmf, vda5050
from omnimate.service.robot.observer import nodes_event
from omnimate.service.routes.common import ALWAYS, Done

router = APIRouter(prefix="/v1", tags=["robot"], responses=ALWAYS)
EVENT_STREAM: dict[int | str, dict[str, Any]] = {
    200: {"content": {"text/event-stream": {"schema": {"type": "string"}}}}
}
KEY_PERIOD = 5.0  # [s] after which a stream looks up its key again
SILENCE = 0.5  # [s] without a frame after which it is checked whether the bus is still read


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
    """The bus as the driver reported it within the last second."""

    syncs: int
    skipped: int
    nodes: list[dict[str, Any]]
    events: list[dict[str, Any]]
    strangers: list[dict[str, Any]]


@router.get("/robot")
async def get_robot(call: Reading) -> Robot:
    """Return which robot is on the bus, where it is, and for which session it drives."""
    robot, status = call.components.robot, call.components.robot.status
    return Robot(
        vehicle=call.components.vehicle,
        mode="simulated" if robot.mode == "simulated" else "bus",
        problem=status.problem,
        driving=status.session,
        samples=status.samples,
        incomplete=status.incomplete,
        state=status.state,
    )


@router.post("/robot/stop")
async def stop_robot(call: Stopping) -> Done:
    """Stop the wheels at the next sample. A session that is driven is interrupted. Every key may stop."""
    call.components.robot.reservation.stop("a client stopped the robot")
    return Done(done="the robot stops")


@router.get("/robot/stream", response_class=StreamingResponse, responses=EVENT_STREAM)
async def stream_robot(call: Reading) -> StreamingResponse:
    """Stream the robot's state, its nodes, and changes of sessions and diagnoses, as server-sent events."""
    return StreamingResponse(
        _while_allowed(call, call.components.events.listen()),
        media_type="text/event-stream",
        headers={"Cache-Control": "no-cache", "X-Accel-Buffering": "no"},
    )


async def _while_allowed(call: Call, events: AsyncGenerator[bytes]) -> AsyncIterator[bytes]:
    """Yield events until the caller's key is revoked; they do not wait for the database that says so."""
    checked, check = time.monotonic(), None
    async with aclosing(events):
        async for event in events:
            yield event
            if check is None and time.monotonic() > checked + KEY_PERIOD:
                check = asyncio.create_task(asyncio.to_thread(call.is_still_allowed))
            elif check is not None and check.done():
                if not check.result():
                    return
                checked, check = time.monotonic(), None


@router.get("/robot/errors")
async def get_errors(call: Reading, format: Literal["vda5050", "open-rmf"] = "vda5050") -> dict[str, Any]:  # noqa: A002
    """Return the present faults as VDA 5050 `errors` or Open-RMF `issues`."""
    faults = vda5050 if format == "vda5050" else open_rmf
    return faults(call.components.robot.status)


@router.get("/bus", response_model=Bus)
async def get_bus(call: Reading) -> Response:
    """Return the nodes of the bus with their counters, and the events of the drive."""
    return Response(_bus(call.components.robot.status.report), media_type="application/json")


@lru_cache(maxsize=1)
def _bus(report: DriverReport | None) -> bytes:
    """Return the body of `GET /v1/bus`, which is made once for each report."""
    if report is None:
        bus = Bus(syncs=0, skipped=0, nodes=[], events=[], strangers=[])
    else:
        bus = Bus(
            syncs=report.syncs,
            skipped=report.skipped,
            nodes=nodes_event(report)["nodes"],
            events=[asdict(event) for event in report.events],
            strangers=[
                {"identifier": key, "what": what, "frames": count}
                for key, what, count in report.unknown_frames
            ],
        )
    return bus.model_dump_json().encode()


@router.get(
    "/bus/frames",
    response_class=PlainTextResponse,
    responses={200: {"content": {"text/plain": {"schema": {"type": "string"}}}}},
)
def stream_frames(
    call: Reading,
    count: Annotated[
        int | None, Query(ge=1, le=1_000_000, description="The number of frames after which the stream ends.")
    ] = None,
) -> StreamingResponse:
    """Stream the frames of the bus as `candump -L` prints them. The stream ends after `count` frames."""
    return StreamingResponse(_lines(call, count), media_type="text/plain")


def _lines(call: Call, count: int | None) -> Iterator[str]:
    components = call.components
    with components.robot.lines.reader() as reader:
        sent, checked = 0, time.monotonic()
        while count is None or sent < count:
            if time.monotonic() > checked + KEY_PERIOD:
                if not call.is_still_allowed():
                    return
                checked = time.monotonic()
            try:
                yield reader.get(timeout=SILENCE) + "\n"
                sent += 1
            except queue.Empty:
                if components.events.is_closed or components.robot.status.problem is not None:
                    return
