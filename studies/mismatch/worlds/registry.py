"""All worlds, by name."""

from __future__ import annotations

import random
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING

from omnimate.vehicle.errors import OmnimateError
from studies.mismatch import run
from studies.mismatch.engines.cases import cases, seed_of, write_case
from studies.mismatch.worlds.injections import write_injections
from studies.mismatch.worlds.optiodom import diagnosed_and_driven, write_optiodom
from studies.mismatch.worlds.world import AbsentError, Label, LabelledWorld, Request, World, WrittenWorld

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from studies.mismatch.run import Report

WIDE, CONTACTS = (6, 300), (6, 46)  # cases of the wide world, and of an engine with contacts: quick, whole


def write_engine(folder: Path, request: Request, jobs: int, report: Report) -> Mapping[str, Label]:
    """Write the cases of the independent engine."""
    wanted = cases(request.quick)
    count = len(wanted) if request.cases is None else min(request.cases, len(wanted))
    numbers = sorted(random.Random(request.seed).sample(range(len(wanted)), count))  # no secret
    made = {
        f"own-{number:04d}": (folder / f"own-{number:04d}", wanted[number], seed_of(request.seed, number))
        for number in numbers
    }
    folder.mkdir(parents=True, exist_ok=True)
    return run.ask_all(write_case, made, jobs, report, folder / "labels.jsonl")


def write_drawn(
    module: str,
    counts: tuple[int, int],
    library: str,
    folder: Path,
    request: Request,
    jobs: int,
    report: Report,
) -> Mapping[str, Label]:
    """Write cases that depend on seed and number alone.

    Args:
        module: Module of the engines whose `make` writes one case.
        counts: How many cases there are, quick and in whole.
        library: Library that the engine needs.
        folder: Folder of the world, with its name.
        request: How much is asked for.
        jobs: How many processes work at once.
        report: Is told how many cases are written.
    """
    _check_installed(library, folder.name)
    make = import_module(f"studies.mismatch.engines.{module}").make
    count = request.cases or counts[0 if request.quick else 1]
    made = {
        f"{folder.name}-{number:04d}": (folder / f"{folder.name}-{number:04d}", request.seed, number)
        for number in range(count)
    }
    folder.mkdir(parents=True, exist_ok=True)
    return run.ask_all(make, made, jobs, report, folder / "labels.jsonl")


def write_mujoco(folder: Path, request: Request, _jobs: int, _report: Report) -> Mapping[str, Label]:
    """Write the cases of the two-truck robot in MuJoCo."""
    _check_installed("mujoco", folder.name)
    corpus = import_module("studies.mismatch.engines.mujoco.corpus")
    count = request.cases or CONTACTS[0 if request.quick else 1]
    labels: Mapping[str, Label] = corpus.write(folder, corpus.corpus(count), request.seed)
    return labels


def _check_installed(library: str, extra: str) -> None:
    if find_spec(library) is None:
        raise AbsentError(f"{library} is not installed (the extra `{extra}`): {extra} is left out")


def worlds(data: Path) -> dict[str, World]:
    """Return all worlds by name; `data` is the folder of labelled sets and of real recordings."""
    every: tuple[World, ...] = (
        WrittenWorld("engine", "own engine", write_engine),
        WrittenWorld("wide", "own engine, wide", partial(write_drawn, "wide.cases", WIDE, "numpy")),
        WrittenWorld("mujoco", "MuJoCo", write_mujoco),
        LabelledWorld("concealed", "concealed", data / "concealed", foreign=True),
        LabelledWorld("concealed2", "concealed2", data / "concealed2", foreign=True),
        LabelledWorld("contact", "contact", data / "contact", foreign=True),
        WrittenWorld(
            "bullet", "PyBullet", partial(write_drawn, "bullet.cases", CONTACTS, "pybullet"), foreign=True
        ),
        WrittenWorld("injections", "injections", partial(write_injections, data)),
        WrittenWorld("optiodom", "OptiOdom", partial(write_optiodom, data), ask=diagnosed_and_driven),
    )
    return {world.name: world for world in every}


def chosen(data: Path, names: Sequence[str]) -> list[World]:
    """Return the worlds of these names, all of them where none is given.

    Raises:
        OmnimateError: There is no world of a name.
    """
    every = worlds(data)
    for name in names:
        if name not in every:
            raise OmnimateError(f"no world {name!r}; expected {', '.join(every)}")
    return [every[name] for name in names or every]
