"""Diagnoses as jobs: started, followed, read, cancelled."""

from __future__ import annotations

import json
from typing import Annotated, Any

from fastapi import APIRouter
from fastapi import Path as PathParameter
from fastapi.responses import HTMLResponse, JSONResponse, Response
from sqlalchemy.orm import Session as Db

from service.errors import StateError
from service.jobs.models import DiagnosisStart, Job
from service.jobs.worker import add_job, cancel_job, job, job_view
from service.once import Answer, Operating, Reading
from service.problems import documented
from service.routes.common import ALWAYS, After, Limit, Page
from service.store.lists import page
from service.store.tables import JobRow
from service.umbmark.models import Id

router = APIRouter(prefix="/v1/diagnoses", tags=["diagnoses"], responses=ALWAYS)
Name = Annotated[Id, PathParameter(description="of the diagnosis")]
REPORT = {
    "Content-Security-Policy": "default-src 'none'; style-src 'unsafe-inline'; img-src data:; "
    "frame-ancestors 'self'; sandbox"
}


@router.post(
    "", operation_id="startDiagnosis", status_code=202, response_model=Job, responses=documented(404)
)
def start(body: DiagnosisStart, call: Operating) -> Response:
    """Diagnose recordings of one robot together."""

    def act(db: Db) -> Answer:
        row = add_job(db, body.recordings)
        return Answer(job_view(row), 202, {"Location": f"{router.prefix}/{row.id}"})

    response = call.once(body, act)
    call.parts.worker.wake()
    return response


@router.get("", operation_id="listDiagnoses", response_model=Page[Job], responses=documented(404))
def every(call: Reading, limit: Limit = 50, after: After = None) -> Page[Job]:
    """Return diagnoses, newest first."""
    with call.parts.database.reading() as db:
        rows, following = page(db, JobRow, limit, after)
        return Page(items=[job_view(row) for row in rows], next=following)


@router.get("/{diagnosis_id}", operation_id="getDiagnosis", response_model=Job, responses=documented(404))
def one(diagnosis_id: Name, call: Reading) -> Job:
    """Return how far a diagnosis is."""
    with call.parts.database.reading() as db:
        return job_view(job(db, diagnosis_id))


@router.get(
    "/{diagnosis_id}/result",
    operation_id="getDiagnosisResult",
    response_model=dict[str, Any],
    responses=documented(404),
)
def result(diagnosis_id: Name, call: Reading) -> Response:
    """Return the diagnosis, in the JSON that every tool of this kind writes."""
    with call.parts.database.reading() as db:
        row = job(db, diagnosis_id)
        return JSONResponse(json.loads(_done(row, row.result)))


@router.get(
    "/{diagnosis_id}/report",
    operation_id="getDiagnosisReport",
    response_class=HTMLResponse,
    responses=documented(404),
)
def report(diagnosis_id: Name, call: Reading) -> Response:
    """Return the report for people, a page with nothing outside itself."""
    with call.parts.database.reading() as db:
        row = job(db, diagnosis_id)
        return HTMLResponse(_done(row, row.report), headers=REPORT)


def _done(row: JobRow, content: str | None) -> str:
    if content is None:
        raise StateError(f"diagnosis {row.id} is {row.state}; it has no result")
    return content


@router.post(
    "/{diagnosis_id}/cancel",
    operation_id="cancelDiagnosis",
    response_model=Job,
    responses=documented(404),
)
def cancel(diagnosis_id: Name, call: Operating) -> Response:
    """End a diagnosis that is not done."""
    return call.once(None, lambda db: Answer(job_view(cancel_job(db, diagnosis_id))))
