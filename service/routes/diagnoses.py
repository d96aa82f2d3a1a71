"""Diagnoses over REST: started as jobs, followed, read, cancelled."""

from __future__ import annotations

import json
from typing import Annotated, Any

from fastapi import APIRouter
from fastapi import Path as PathParameter
from fastapi.responses import HTMLResponse, JSONResponse, Response
from sqlalchemy.orm import Session as Db

from omnimate.service.calls import Answer, Operating, Reading
from omnimate.service.errors import StateError
from omnimate.service.jobs.queue import DiagnosisStart, Job, add_job, cancel_job
from omnimate.service.routes.common import ALWAYS, After, Limit, Page
from omnimate.service.store.tables import DiagnosisRow, JobRow, find_row, read_page
from omnimate.service.umbmark.models import Id

router = APIRouter(prefix="/v1/diagnoses", tags=["diagnoses"], responses=ALWAYS)
DiagnosisId = Annotated[Id, PathParameter(description="The id of the diagnosis.")]
REPORT_HEADERS = {
    "Content-Security-Policy": "default-src 'none'; style-src 'unsafe-inline'; img-src data:; "
    "frame-ancestors 'self'; sandbox"
}


@router.post("", status_code=202, response_model=Job)
def start_diagnosis(body: DiagnosisStart, call: Operating) -> Response:
    """Start a diagnosis of recordings, which are all of one robot.

    It is done at once where this version of the service has diagnosed the same recordings before.
    """

    def act(db: Db) -> Answer:
        row = add_job(db, body.recordings, call.caller.name)
        return Answer(Job.of(row), 202, {"Location": f"{router.prefix}/{row.id}"})

    response = call.change(body, act)
    call.components.worker.wake()
    return response


@router.get("")
def list_diagnoses(call: Reading, limit: Limit = 50, after: After = None) -> Page[Job]:
    """Return the diagnoses, newest first."""
    with call.components.database.reading() as db:
        rows, next_page = read_page(db, DiagnosisRow, limit, after)
        return Page(items=[Job.of(row) for row in rows], next=next_page)


@router.get("/{diagnosis_id}")
def get_diagnosis(diagnosis_id: DiagnosisId, call: Reading) -> Job:
    """Return the state and the progress of a diagnosis."""
    with call.components.database.reading() as db:
        return Job.of(find_row(db, DiagnosisRow, diagnosis_id))


@router.get("/{diagnosis_id}/result", response_model=dict[str, Any])
def get_diagnosis_result(diagnosis_id: DiagnosisId, call: Reading) -> Response:
    """Return the diagnosis as JSON, as `omnimate diagnose --json` writes it."""
    with call.components.database.reading() as db:
        row = find_row(db, DiagnosisRow, diagnosis_id)
        return JSONResponse(json.loads(_require_done(row, row.result)))


@router.get("/{diagnosis_id}/report", response_class=HTMLResponse)
def get_diagnosis_report(diagnosis_id: DiagnosisId, call: Reading) -> Response:
    """Return the report as an HTML page that needs no other file."""
    with call.components.database.reading() as db:
        row = find_row(db, DiagnosisRow, diagnosis_id)
        return HTMLResponse(_require_done(row, row.report), headers=REPORT_HEADERS)


def _require_done(row: JobRow, content: str | None) -> str:
    """Return the result or the report of a job; StateError where there is none."""
    if content is None:
        raise StateError(f"diagnosis {row.id} is {row.state}; it has no result")
    return content


@router.post("/{diagnosis_id}/cancel", response_model=Job)
def cancel_diagnosis(diagnosis_id: DiagnosisId, call: Operating) -> Response:
    """Cancel a diagnosis that has not ended."""

    def act(db: Db) -> Answer:
        return Answer(Job.of(cancel_job(find_row(db, DiagnosisRow, diagnosis_id, for_change=True))))

    return call.change(None, act)
