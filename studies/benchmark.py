"""What all benchmarks share: options of the command line, times, and whole processes with their cost."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

OMNIMATE = (sys.executable, "-m", "omnimate.cli.main")


class Cost(NamedTuple):
    """What some work took: time by the wall and of processors [s], and the largest memory [MB]."""

    wall: float
    processor: float
    memory: float = 0.0


def options(
    doc: str | None,
    positional: Mapping[str, str | float] | None = None,
    **named: str | float | bool | None,
) -> argparse.Namespace:
    """Return the options of the command line, whose help is a docstring, by the default of each.

    Positional arguments may be left out; False makes a switch, None an option without a default.
    """
    parser = argparse.ArgumentParser(
        description=doc, formatter_class=argparse.RawDescriptionHelpFormatter, usage=argparse.SUPPRESS
    )
    for name, default in (positional or {}).items():
        parser.add_argument(name, nargs="?", type=type(default), default=default)
    for name, value in named.items():
        flag = "--" + name.replace("_", "-")
        if isinstance(value, bool):
            parser.add_argument(flag, action="store_true")
        else:
            parser.add_argument(flag, type=str if value is None else type(value), default=value)
    return parser.parse_args()


def duration(work: Callable[[], object], clock: Callable[[], float] = time.perf_counter) -> float:
    """Return the time of a call [s]."""
    begin = clock()
    work()
    return clock() - begin


def best(
    work: Callable[[], object], rounds: int = 5, clock: Callable[[], float] = time.perf_counter
) -> float:
    """Return the shortest time of several calls [s], because the machine may be shared."""
    return min(duration(work, clock) for _ in range(rounds))


def cost(work: Callable[[], object]) -> Cost:
    """Return what a call took in this process."""
    processor = time.process_time()
    wall = duration(work)
    return Cost(wall, time.process_time() - processor)


def process_cost(
    command: Sequence[str], source: Path | None = None, folder: str | Path | None = None
) -> Cost:
    """Return what a process took that reads a file, if any, on its standard input; its output is dropped.

    The largest memory of a process counts from that of the process that starts it. RuntimeError: it failed.
    """
    stdin = os.open(source or os.devnull, os.O_RDONLY)
    begin = time.perf_counter()
    process = subprocess.Popen(
        command, cwd=folder, stdin=stdin, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    _, status, usage = os.wait4(process.pid, 0)
    wall = time.perf_counter() - begin
    process.returncode = os.waitstatus_to_exitcode(status)
    os.close(stdin)
    if status:
        raise RuntimeError(f"{' '.join(command)}: exit code {process.returncode}")
    return Cost(wall, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024.0)


def least(costs: Sequence[Cost]) -> Cost:
    """Return the least of each column."""
    return Cost(*map(min, zip(*costs, strict=True)))
