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
from studies.mismatch.engines.wide import cases as wide
from studies.mismatch.worlds.injections import write_injections
from studies.mismatch.worlds.optiodom import diagnosed_and_driven, write_optiodom
from studies.mismatch.worlds.world import AbsentError, Label, LabelledWorld, Request, World, WrittenWorld

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from studies.mismatch.run import Report

QUICK_WIDE, WIDE = 6, 300  # cases of the wide distributions, quick and in whole
QUICK_CONTACTS, CONTACTS = 6, 46  # cases of an engine with contacts, quick and in whole


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


def write_wide(folder: Path, request: Request, jobs: int, report: Report) -> Mapping[str, Label]:
    """Write the cases of the independent engine with everything drawn anew, from wide distributions."""
    count = request.cases or (QUICK_WIDE if request.quick else WIDE)
    made = {
        f"wide-{number:04d}": (folder / f"wide-{number:04d}", request.seed, number) for number in range(count)
    }
    folder.mkdir(parents=True, exist_ok=True)
    return run.ask_all(wide.make, made, jobs, report, folder / "labels.jsonl")


def write_mujoco(folder: Path, request: Request, _jobs: int, _report: Report) -> Mapping[str, Label]:
    """Write the cases of the two-truck robot in MuJoCo."""
    _check_installed("mujoco", "mujoco")
    corpus = import_module("studies.mismatch.engines.mujoco.corpus")
    labels: Mapping[str, Label] = corpus.write(folder, corpus.corpus(_count(request)), request.seed)
    return labels


def write_bullet(folder: Path, request: Request, jobs: int, report: Report) -> Mapping[str, Label]:
    """Write the cases of foreign robots in PyBullet."""
    _check_installed("pybullet", "bullet")
    make = import_module("studies.mismatch.engines.bullet.cases").make
    made = {
        f"bullet-{number:04d}": (folder / f"bullet-{number:04d}", request.seed, number)
        for number in range(_count(request))
    }
    folder.mkdir(parents=True, exist_ok=True)
    return run.ask_all(make, made, jobs, report, folder / "labels.jsonl")


def _count(request: Request) -> int:
    return request.cases or (QUICK_CONTACTS if request.quick else CONTACTS)


def _check_installed(library: str, extra: str) -> None:
    if find_spec(library) is None:
        raise AbsentError(f"{library} is not installed (the extra `{extra}`): {extra} is left out")


def worlds(data: Path) -> dict[str, World]:
    """Return all worlds by name; `data` is the folder of labelled sets and of real recordings."""
    every: tuple[World, ...] = (
        WrittenWorld("engine", "own engine", write_engine),
        WrittenWorld("wide", "own engine, wide", write_wide),
        WrittenWorld("mujoco", "MuJoCo", write_mujoco),
        LabelledWorld("concealed", "concealed", data / "concealed", foreign=True),
        LabelledWorld("concealed2", "concealed2", data / "concealed2", foreign=True),
        LabelledWorld("contact", "contact", data / "contact", foreign=True),
        WrittenWorld("bullet", "PyBullet", write_bullet, foreign=True),
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
