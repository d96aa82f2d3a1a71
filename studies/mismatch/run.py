"""Questions to a tool about cases, answered in several processes, with answers that survive a stop."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, TypeVar

from threadpoolctl import threadpool_limits

from omnimate.files.recordings.folder import load_recording
from omnimate.mismatch import Diagnosis, diagnose
from omnimate.vehicle.errors import OmnimateError
from omnimate.vehicle.recording import Recording

Report = Callable[[int, int], None]  # called with how much is done, and of how much
Progress = Callable[[str], AbstractContextManager[Report]]  # called with what is being done

Question = tuple[Path, dict[str, Any]]  # the folder of a case, and its label, of which no tool sees the truth
Answer = dict[str, Any]
Answers = Mapping[str, Answer]  # by case
Tool = Callable[[Sequence[Recording]], Diagnosis]


def recordings_of(question: Question) -> list[Recording]:
    """Return the recordings of a case; OmnimateError where one of them cannot be read."""
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


Asked = TypeVar("Asked")
Reply = TypeVar("Reply")


def ask_all(
    ask: Callable[[Asked], Reply],
    questions: Mapping[str, Asked],
    jobs: int,
    report: Callable[[int, int], None],
    kept: Path | None = None,
) -> dict[str, Reply]:
    """Return the answers to questions, by name.

    What the file `kept` holds is not asked again; it receives every answer as a line of JSON.
    """
    answers: dict[str, Reply] = {} if kept is None else _known(kept)
    waiting = {name: question for name, question in questions.items() if name not in answers}
    # one thread each for matrices, as all cores are busy already
    with ProcessPoolExecutor(jobs, initializer=threadpool_limits, initargs=(1,)) as pool:
        for name, answer in zip(waiting, pool.map(ask, waiting.values()), strict=True):
            answers[name] = answer
            report(len(answers), len(questions))
            if kept is not None:
                with kept.open("a", encoding="utf-8") as file:
                    file.write(json.dumps([name, answer]) + "\n")
    return answers


def _known(kept: Path) -> dict[str, Any]:
    """Return the answers in a file, and remove a last line that is not complete."""
    if not kept.exists():
        return {}
    text = kept.read_text(encoding="utf-8")
    whole = text[: text.rfind("\n") + 1]
    if whole != text:
        kept.write_text(whole, encoding="utf-8")
    return dict(json.loads(line) for line in whole.splitlines())
