"""The study of learned laws: each effect is left out of the library, and a law is learned in its place."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from rich.table import Table

from omnimate.cli.tables import new_table
from studies.figures import plot_recovery
from studies.mismatch import run
from studies.mismatch.laws.baselines import has_sindy
from studies.mismatch.laws.recovery import LAW, METHODS, SINDY, Recovery, recovered, wanted
from studies.mismatch.run import Progress

CASES = 3  # of each effect
CLEAR = 30.0  # [nat] of the effect's own gain, below which a drive hardly shows it: 7.7 sigma
ENOUGH = 0.8  # share of that gain that a law is to recover
RESULT, FIGURE = "laws.json", "laws.png"


def study(
    place: Path,
    seed: int,
    jobs: int,
    progress: Progress,
    figures: Path | None = None,
    *,
    count: int = CASES,
    quick: bool = False,
) -> Iterator[Table | str]:
    """Carry the study out, and yield its table and sentences.

    Raises:
        PlotError: The figure cannot be written.
    """
    place.mkdir(parents=True, exist_ok=True)
    questions = {
        f"{case.effects[0][0]}-{number}": (case, number) for case, number in wanted(count, seed, quick=quick)
    }
    with progress("learning laws") as report:
        answers = run.ask_all(recovered, questions, jobs, report, place / "laws.answers.jsonl")
    found = [answers[name] for name in questions]
    (place / RESULT).write_text(json.dumps(found, indent=1), encoding="utf-8")
    if not has_sindy():
        yield f"{SINDY} is not installed (pip install omnimate[laws]): it is left out"
    clear = [one for one in found if one["gain"] >= CLEAR]
    if len(clear) < len(found):
        yield (
            f"{len(found) - len(clear)} of {len(found)} drives hardly show what is concealed "
            f"(gain below {CLEAR:g} nat): left out"
        )
    if not clear:
        return
    yield table(clear)
    if figures is not None:
        plot_recovery({name: shares(_of(clear, name)) for name in _effects(clear)}, ENOUGH, figures / FIGURE)


def shares(found: Sequence[Recovery]) -> dict[str, list[float]]:
    """Return of each method the shares of the effects' gains that it recovers."""
    return {
        method: [one["gains"][method] / one["gain"] for one in found]
        for method in METHODS
        if all(method in one["gains"] for one in found)
    }


def table(found: Sequence[Recovery]) -> Table:
    """Return a table of the shares that are recovered, a row for each effect."""
    heads = [head for method in shares(found) for head in (f"{method}\nmedian", f"{ENOUGH:g}", "< 0")]
    what = "Laws learned in the place of effects: share of the effect's own gain on an unseen drive"
    shown = new_table(what, ("effect",), ("cases", *heads))
    shown.caption = (
        f"{ENOUGH:g}: cases in which {ENOUGH:g} or more of it is recovered; < 0: worse than nothing"
    )
    rows = [(name, _of(found, name)) for name in _effects(found)]
    for name, own in [*rows, ("all", found)]:
        cells = []
        for values in shares(own).values():
            enough, worse = (np.sum(np.array(values) >= ENOUGH), np.sum(np.array(values) < 0.0))
            cells += [f"{np.median(values):.2f}", f"{enough}/{len(values)}", str(worse)]
        shown.add_row(name, str(len(own)), *cells, end_section=name == _effects(found)[-1])
    return shown


def _effects(found: Sequence[Recovery]) -> list[str]:
    """Return the effects in the order of what a law recovers of them, most first."""
    names = list(dict.fromkeys(one["effect"] for one in found))
    return sorted(names, key=lambda name: -float(np.median(shares(_of(found, name))[LAW])))


def _of(found: Sequence[Recovery], effect: str) -> list[Recovery]:
    return [one for one in found if one["effect"] == effect]
