"""The bodies of requests and answers about diagnoses."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, Field

from omnimate.service.umbmark.models import Id, RequestModel

JobKind = Literal["diagnose", "batch"]
JobState = Literal["queued", "running", "done", "failed", "cancelled"]


class DiagnosisStart(RequestModel):
    """The recordings that are diagnosed together; they are all of one robot."""

    recordings: Annotated[list[Id], Field(min_length=1, max_length=50)]


class Job(BaseModel):
    """A diagnosis that waits, is running, or has ended."""

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
