"""Recordings over REST: uploaded as zip files, listed, downloaded, deleted."""

from __future__ import annotations

import tempfile
import time
from typing import Annotated

from fastapi import APIRouter, Depends, Query, Request
from fastapi import Path as PathParameter
from fastapi.responses import Response
from pydantic import BeforeValidator, Field
from sqlalchemy.orm import Session as Db

from omnimate.service.calls import Answer, Operating, Reading
from omnimate.service.routes.common import ALWAYS, After, Done, Limit, Page, require_type
from omnimate.service.store.tables import RecordingFileRow, RecordingRow, find_row, read_page
from omnimate.service.umbmark.models import Id, Name, RowModel

router = APIRouter(prefix="/v1/recordings", tags=["recordings"], responses=ALWAYS)
RecordingId = Annotated[Id, PathParameter(description="The id of the recording.")]
ZIP_TYPES = ("application/zip", "application/x-zip-compressed", "application/octet-stream")
MAX_IN_MEMORY = 4_000_000  # [bytes] of an upload; a larger one is written to a temporary file
ZIP_CONTENT = {"application/zip": {"schema": {"type": "string", "format": "binary"}}}
ZIP_BODY = {"requestBody": {"required": True, "content": ZIP_CONTENT}}


class Recording(RowModel):
    """A stored recording."""

    id: str
    name: str
    vehicle: str
    samples: int
    seconds: float
    laps: int
    poses: int
    size: int
    problems: Annotated[
        list[str],
        BeforeValidator(lambda problems: problems or []),  # null of an earlier version, or one driven here
        Field(description="What of its log could not be read, 20 sentences at most; the rest was."),
    ]
    created: float


async def zip_of(request: Request) -> bytes:
    """Return the body of a request; MediaTypeError where it is no zip by its content type."""
    require_type(request, ZIP_TYPES, "the zip of a recording folder")
    with tempfile.SpooledTemporaryFile(MAX_IN_MEMORY) as spool:
        async for block in request.stream():
            spool.write(block)
        spool.seek(0)
        return spool.read()


Zip = Annotated[bytes, Depends(zip_of)]


@router.post("", status_code=201, response_model=Recording, openapi_extra=ZIP_BODY)
def upload_recording(
    call: Operating,
    content: Zip,  # after the call: the body of a caller who may not upload is not read
    name: Annotated[Name | None, Query(description="The name of the recording in lists.")] = None,
) -> Response:
    """Upload a zip of a recording folder. The recording is read completely before it is kept."""

    def act(db: Db, row: RecordingRow) -> Answer:
        db.add(row)
        return Answer(Recording.of(row), 201, {"Location": f"{router.prefix}/{row.id}"})

    store = call.components.recordings
    return call.compute_and_change(content, lambda: store.add_upload(name or "uploaded", content), act)


@router.get("")
def list_recordings(call: Reading, limit: Limit = 50, after: After = None) -> Page[Recording]:
    """Return the recordings, newest first."""
    with call.components.database.reading() as db:
        rows, next_page = read_page(db, RecordingRow, limit, after)
        return Page(items=[Recording.of(row) for row in rows], next=next_page)


@router.get("/{recording_id}")
def get_recording(recording_id: RecordingId, call: Reading) -> Recording:
    """Return a recording without its content."""
    with call.components.database.reading() as db:
        return Recording.of(find_row(db, RecordingRow, recording_id))


@router.get("/{recording_id}/download", response_class=Response, responses={200: {"content": ZIP_CONTENT}})
def download_recording(recording_id: RecordingId, call: Reading) -> Response:
    """Return the zip of the recording folder."""
    with call.components.database.reading() as db:
        row = find_row(db, RecordingRow, recording_id)
    content = call.components.recordings.content(row)
    headers = {"Content-Disposition": f'attachment; filename="recording-{recording_id}.zip"'}
    return Response(content, media_type="application/zip", headers=headers)


@router.delete("/{recording_id}", response_model=Done)
def delete_recording(recording_id: RecordingId, call: Operating) -> Response:
    """Delete a recording."""

    def act(db: Db) -> Answer:
        db.delete(find_row(db, RecordingRow, recording_id))
        db.merge(RecordingFileRow(id=recording_id, created=time.time()))
        return Answer(Done(done=f"recording {recording_id} is deleted"))

    response = call.change(None, act)
    call.components.recordings.delete(recording_id)
    return response
