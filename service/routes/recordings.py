"""Recordings: uploaded as zips, listed, downloaded, deleted."""

from __future__ import annotations

import tempfile
from typing import Annotated

from fastapi import APIRouter, Query, Request
from fastapi import Path as PathParameter
from fastapi.responses import Response
from pydantic import BaseModel
from sqlalchemy.orm import Session as Db
from starlette.concurrency import run_in_threadpool

from service.errors import MediaProblem, NotThereError
from service.once import Answer, Call, Operating, Reading
from service.problems import documented
from service.recordings import checked
from service.routes.common import ALWAYS, After, Done, Limit, Page
from service.store.lists import page
from service.store.tables import RecordingRow
from service.umbmark.models import Id
from service.umbmark.models import Name as Text

router = APIRouter(prefix="/v1/recordings", tags=["recordings"], responses=ALWAYS)
Name = Annotated[Id, PathParameter(description="of the recording")]
ZIP = ("application/zip", "application/x-zip-compressed", "application/octet-stream")
IN_MEMORY = 4_000_000  # bytes of an upload; the rest waits on the disk
BINARY = {"schema": {"type": "string", "format": "binary"}}


class Recording(BaseModel):
    """What is known of a recording."""

    id: str
    name: str
    vehicle: str
    samples: int
    seconds: float
    laps: int
    poses: int
    size: int
    created: float


def view(row: RecordingRow) -> Recording:
    """Return a recording as clients see it."""
    return Recording.model_validate(row, from_attributes=True)


@router.post(
    "",
    operation_id="uploadRecording",
    status_code=201,
    response_model=Recording,
    responses=documented(415),
    openapi_extra={"requestBody": {"required": True, "content": {"application/zip": BINARY}}},
)
async def upload(
    request: Request, call: Operating, name: Annotated[Text | None, Query(description="for people")] = None
) -> Response:
    """Take a zip of a recording folder; it is read before it is kept."""
    kind = request.headers.get("content-type", ZIP[0]).partition(";")[0].strip().lower()
    if kind not in ZIP:
        raise MediaProblem(f"content type {kind!r}; expected application/zip, the zip of a recording folder")
    with tempfile.SpooledTemporaryFile(IN_MEMORY) as spool:
        async for block in request.stream():
            spool.write(block)
        spool.seek(0)
        return await run_in_threadpool(_keep, call, name, spool.read())


def _keep(call: Call, name: str | None, content: bytes) -> Response:
    row = checked(name or "uploaded", content, call.parts.settings.unpacked)

    def act(db: Db) -> Answer:
        db.add(row)
        return Answer(view(row), 201, {"Location": f"{router.prefix}/{row.id}"})

    return call.once(content, act)


@router.get("", operation_id="listRecordings", response_model=Page[Recording], responses=documented(404))
def every(call: Reading, limit: Limit = 50, after: After = None) -> Page[Recording]:
    """Return recordings, newest first."""
    with call.parts.database.reading() as db:
        rows, following = page(db, RecordingRow, limit, after)
        return Page(items=[view(row) for row in rows], next=following)


@router.get(
    "/{recording_id}", operation_id="getRecording", response_model=Recording, responses=documented(404)
)
def one(recording_id: Name, call: Reading) -> Recording:
    """Return what is known of a recording."""
    with call.parts.database.reading() as db:
        return view(_row(db, recording_id))


@router.get(
    "/{recording_id}/download",
    operation_id="downloadRecording",
    response_class=Response,
    responses={**documented(404), 200: {"content": {"application/zip": BINARY}}},
)
def download(recording_id: Name, call: Reading) -> Response:
    """Return the zip."""
    with call.parts.database.reading() as db:
        content = _row(db, recording_id).content
    headers = {"Content-Disposition": f'attachment; filename="recording-{recording_id}.zip"'}
    return Response(content, media_type="application/zip", headers=headers)


@router.delete(
    "/{recording_id}", operation_id="deleteRecording", response_model=Done, responses=documented(404)
)
def delete(recording_id: Name, call: Operating) -> Response:
    """Delete a recording."""

    def act(db: Db) -> Answer:
        db.delete(_row(db, recording_id))
        return Answer(Done(done=f"recording {recording_id} is deleted"))

    return call.once(None, act)


def _row(db: Db, name: str) -> RecordingRow:
    row = db.get(RecordingRow, name)
    if row is None:
        raise NotThereError("recording", name)
    return row
