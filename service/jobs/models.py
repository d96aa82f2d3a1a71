"""What clients send and get of diagnoses."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, Field

from service.umbmark.models import Id, Sent

JobState = Literal["queued", "running", "done", "failed", "cancelled"]


class DiagnosisStart(Sent):
    """Which recordings, all of one robot."""

    recordings: Annotated[list[Id], Field(min_length=1, max_length=50)]


class Job(BaseModel):
    """A diagnosis, queued or going on or ended."""

    id: str
    kind: Literal["diagnose"] = "diagnose"
    recordings: list[str]
    state: JobState
    progress: float
    doing: str
    verdict: str | None
    says: str | None
    error: str | None
    attempts: int
    created: float
    changed: float
