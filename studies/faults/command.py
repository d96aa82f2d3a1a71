"""`python -m studies faults`: the driver with faults drawn from a seed, and the laws that it breaks."""

from __future__ import annotations

import hashlib
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from itertools import count, islice
from typing import Annotated

import typer

from omnimate.cli.console import out, progress_bar, report_problem
from omnimate.cli.tables import new_table, show
from studies.faults.script import BUS_FAULTS, DISK_FAULTS, LENGTH, NODE_FAULTS, Script, draw, shrink
from studies.faults.session import PHASES, Outcome, run

SHRUNKEN = 3  # failing sessions that are shortened: each takes minutes


def faults(
    seed: Annotated[int, typer.Option(help="Seed of all that is drawn by chance.", min=0)] = 1,
    hours: Annotated[float, typer.Option(help="Time that the robots drive [h].", min=0.0)] = 1.0,
    jobs: Annotated[int, typer.Option(help="Processes that work at once.", min=1)] = 2,
) -> None:
    """Drive simulated robots while everything fails, and check what must hold all the time.

    Driver, devices and bus run on one simulated time, so that a seed always gives the same trace.
    """
    began, sessions = time.perf_counter(), max(1, round(3600.0 * hours / LENGTH))
    outcomes = []
    with progress_bar("driving") as update:
        for outcome in run_all(seed, sessions, jobs):
            outcomes.append(outcome)
            update(len(outcomes), sessions, None)
    passed = time.perf_counter() - began
    _show(outcomes)
    trace = hashlib.sha256("".join(outcome.digest for outcome in outcomes).encode()).hexdigest()
    driven = sessions * LENGTH / 3600.0
    broken = [outcome for outcome in outcomes if outcome.violations]
    out.print(
        f"{driven:.2f} robot-hours in {passed:.0f} s: {driven / passed:.4f} robot-hours per second, "
        f"{3600.0 * driven / passed:.0f} times real time",
        soft_wrap=True,
    )
    worst = max(outcome.worst for outcome in outcomes)
    out.print(f"largest error of a step of the pose without lost samples: {1e3 * worst:.3f} mm")
    out.print(f"sessions with violations: {len(broken)} of {sessions}; trace {trace}", soft_wrap=True)
    for outcome in broken[:SHRUNKEN]:
        shortest = shrink(outcome.script, partial(_fails_like, outcome.violations[0]))
        report_problem(f"{outcome.violations[0]}; the shortest session that does so:")
        out.print(f"run({shortest})", soft_wrap=True)


def run_all(seed: int, sessions: int, jobs: int) -> Iterator[Outcome]:
    """Yield the outcome of each session of a seed, in order."""
    scripts = map(partial(draw, seed), islice(count(), sessions))
    with ProcessPoolExecutor(jobs) as pool:
        yield from pool.map(run, scripts)


def _fails_like(violation: str, script: Script) -> bool:
    """Return whether a session breaks the same law; its first words say which."""
    law = _law(violation)
    return any(_law(other) == law for other in run(script).violations)


def _law(violation: str) -> str:
    """Return which law is broken: a violation's words after its time, without numbers."""
    words = violation.partition(": ")[2]
    return " ".join(word for word in words.split()[:5] if word.isalpha())


def _show(outcomes: list[Outcome]) -> None:
    injected, expected, reported = (
        sum((getattr(outcome, name) for outcome in outcomes), Counter[tuple[str, str]]())
        for name in ("injected", "expected", "reported")
    )
    table = new_table("faults injected in each phase, and reported of those that must be", ("fault",))
    for head in (*PHASES, "must be reported", "reported"):
        table.add_column(head, justify="right")
    for kind in (*NODE_FAULTS, *BUS_FAULTS, *DISK_FAULTS):
        cells = [injected[kind, phase] for phase in PHASES]
        cells += [sum(tally[kind, phase] for phase in PHASES) for tally in (expected, reported)]
        table.add_row(kind, *map(str, cells))
    show(table)
