"""Fleets over REST: their recordings, and the batches that process these."""

from __future__ import annotations

import time
from typing import Annotated

from fastapi import APIRouter
from fastapi import Path as PathParameter
from fastapi.responses import Response
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session as Db

from omnimate.fleet.batch.store import StoredRecording
from omnimate.fleet.batch.work import delete_recording
from omnimate.fleet.report_store import find_latest_day
from omnimate.service.calls import Answer, Operating, Reading
from omnimate.service.errors import NotFoundError, StateError
from omnimate.service.fleets.batches import add_batch, batch_view, require_no_batch
from omnimate.service.fleets.findings import go_back
from omnimate.service.fleets.models import Batch, BatchStart, Day, Fleet, FleetStart, PlainName, Upload
from omnimate.service.fleets.results import fleet_view
from omnimate.service.fleets.upload import store_day
from omnimate.service.jobs.queue import cancel_job
from omnimate.service.routes.common import ALWAYS, After, Done, Limit, Page
from omnimate.service.routes.recordings import ZIP_BODY, Zip
from omnimate.service.store.tables import BatchRow, FleetRow, find_row, read_page
from omnimate.service.umbmark.models import Id

PREFIX = "/v1/fleets"
router = APIRouter(prefix=PREFIX, tags=["fleets"], responses=ALWAYS)
FleetName = Annotated[PlainName, PathParameter(description="The name of the fleet.")]
RobotName = Annotated[PlainName, PathParameter(description="The name of the robot.")]
RecordingDay = Annotated[Day, PathParameter(description="The date of the recording.")]
RecordingName = Annotated[PlainName, PathParameter(description="The name of the recording.")]
BatchId = Annotated[Id, PathParameter(description="The id of the batch.")]


@router.post("", status_code=201, response_model=Fleet)
def create_fleet(body: FleetStart, call: Operating) -> Response:
    """Make a fleet: robots that share floors, each of which has one frame of poses."""
    row = FleetRow(id=body.name, created=time.time())

    def act(db: Db, view: Fleet) -> Answer:
        db.add(row)
        try:
            db.flush()
        except IntegrityError as error:
            raise StateError(f"fleet {body.name!r} exists already") from error
        return Answer(view, 201, {"Location": f"{PREFIX}/{row.id}"})

    results = call.components.stores.results_of(row.id)
    return call.compute_and_change(body, lambda: fleet_view(row, results), act)


@router.get("")
def list_fleets(call: Reading, limit: Limit = 50, after: After = None) -> Page[Fleet]:
    """Return the fleets, newest first."""
    with call.components.database.reading() as db:
        rows, next_page = read_page(db, FleetRow, limit, after)
    stores = call.components.stores
    return Page(items=[fleet_view(row, stores.results_of(row.id)) for row in rows], next=next_page)


@router.get("/{fleet}")
def get_fleet(fleet: FleetName, call: Reading) -> Fleet:
    """Return a fleet, with its robots by their state in the latest report."""
    with call.components.database.reading() as db:
        row = find_row(db, FleetRow, fleet)
    return fleet_view(row, call.components.stores.results_of(fleet))


@router.post("/{fleet}/recordings", status_code=201, response_model=Upload, openapi_extra=ZIP_BODY)
def upload_day(fleet: FleetName, call: Operating, content: Zip) -> Response:
    """Upload a zip of folders robot=NAME/day=YYYY-MM-DD/RECORDING/. What is there already is replaced.

    Recordings that cannot be read are named in `refused`, and the others are stored.
    """

    def store() -> Upload:
        with call.components.database.reading() as db:
            find_row(db, FleetRow, fleet)
        files = call.components.stores.recordings_of(fleet)
        return store_day(files, content, call.components.settings.unpacked, time.time())

    return call.compute_and_change(content, store, lambda _db, stored: Answer(stored, 201))


@router.delete("/{fleet}/recordings/{robot}/{day}/{recording}", response_model=Done)
def delete_fleet_recording(
    fleet: FleetName, robot: RobotName, day: RecordingDay, recording: RecordingName, call: Operating
) -> Response:
    """Delete a recording and its results, and the report of its day where no other one has results of it."""
    stored = StoredRecording(robot, day, recording)

    def delete() -> str | None:
        with call.components.database.reading() as db:
            find_row(db, FleetRow, fleet)
            require_no_batch(db, fleet)
        stores = call.components.stores
        results = stores.results_of(fleet)
        if not delete_recording(stores.recordings_of(fleet), results, stored):
            raise NotFoundError("recording", f"{stored.partition}/{recording}")
        return find_latest_day(results)

    def act(db: Db, latest: str | None) -> Answer:
        go_back(db, fleet, latest)
        return Answer(Done(done=f"recording {stored.partition}/{recording} is deleted"))

    return call.compute_and_change(None, delete, act)


@router.post("/{fleet}/batches", status_code=202, response_model=Batch)
def start_batch(fleet: FleetName, body: BatchStart, call: Operating) -> Response:
    """Start a batch: results of all recordings that are not known yet, and the daily report."""

    def act(db: Db) -> Answer:
        row = add_batch(db, fleet, body)
        return Answer(batch_view(row), 202, {"Location": f"{PREFIX}/{fleet}/batches/{row.id}"})

    response = call.change(body, act)
    call.components.batch_worker.wake()
    return response


@router.get("/{fleet}/batches")
def list_batches(fleet: FleetName, call: Reading, limit: Limit = 50, after: After = None) -> Page[Batch]:
    """Return the batches of a fleet, newest first."""
    with call.components.database.reading() as db:
        find_row(db, FleetRow, fleet)
        rows, next_page = read_page(db, BatchRow, limit, after, BatchRow.fleet == fleet)
        return Page(items=[batch_view(row) for row in rows], next=next_page)


@router.get("/{fleet}/batches/{batch_id}")
def get_batch(fleet: FleetName, batch_id: BatchId, call: Reading) -> Batch:
    """Return the state and the progress of a batch."""
    with call.components.database.reading() as db:
        find_row(db, FleetRow, fleet)
        return batch_view(find_row(db, BatchRow, batch_id, fleet=fleet))


@router.post("/{fleet}/batches/{batch_id}/cancel", response_model=Batch)
def cancel_batch(fleet: FleetName, batch_id: BatchId, call: Operating) -> Response:
    """Cancel a batch that has not ended. The results that it has made stay."""

    def act(db: Db) -> Answer:
        find_row(db, FleetRow, fleet)
        row = find_row(db, BatchRow, batch_id, for_change=True, fleet=fleet)
        return Answer(batch_view(cancel_job(row)))

    return call.change(None, act)
