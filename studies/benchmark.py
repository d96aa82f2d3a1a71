"""What all benchmarks share: options of the command line, and times."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Mapping
from typing import NamedTuple

OMNIMATE = (sys.executable, "-m", "omnimate.cli.main")


class Cost(NamedTuple):
    """What some work took: time by the wall and of processors [s]."""

    wall: float
    processor: float


def options(
    doc: str | None,
    positional: Mapping[str, str | float] | None = None,
    **named: str | float | bool | None,
) -> argparse.Namespace:
    """Return the options of the command line.

    Args:
        doc: Docstring of the benchmark, which is its help.
        positional: Default of each positional argument, which may be left out.
        named: Default of each named option; False makes a switch, None an option without a default.
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
