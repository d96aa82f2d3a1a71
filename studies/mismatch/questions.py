"""What is asked about one case, and of which tool."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from omnimate.files.recordings.folder import load_recording
from omnimate.mismatch import Diagnosis, diagnose
from omnimate.vehicle.errors import OmnimateError
from omnimate.vehicle.recording import Recording

Question = tuple[Path, dict[str, Any]]  # the folder of a case, and its label, of which no tool sees the truth
Answer = dict[str, Any]
Tool = Callable[[Sequence[Recording]], Diagnosis]


def recordings_of(question: Question) -> list[Recording]:
    """Return the recordings of a case.

    Raises:
        OmnimateError: One of them cannot be read.
    """
    folder, label = question
    return [load_recording(folder / name) for name in label["recordings"]]


def answered(question: Question, tool: Tool = diagnose) -> Answer:
    """Return a tool's answer to all recordings of a case, as JSON; a refusal is an answer too."""
    return answer_of(lambda: tool(recordings_of(question)).as_json())


def answer_of(ask: Callable[[], Answer]) -> Answer:
    """Return an answer; a refusal is one too, and so is a failure: a study of hours goes on without it."""
    try:
        return ask()
    except OmnimateError as error:
        return {"verdict": "error", "says": str(error), "findings": [], "fit": None}
    except Exception as error:  # noqa: BLE001  # whatever fails is shown as that
        says = f"FAILED with {type(error).__name__}: {error}"
        return {"verdict": "error", "says": says, "findings": [], "fit": None}


def answered_by(wanted: tuple[Tool, Question]) -> Answer:
    """Do as `answered`, in one argument."""
    tool, question = wanted
    return answered(question, tool)
