"""All worlds, by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from omnimate.vehicle.errors import OmnimateError
from studies.mismatch.engines.scene import cases, make, seed_of
from studies.mismatch.run import Report
from studies.mismatch.worlds.injections import write_injections
from studies.mismatch.worlds.optiodom import diagnosed_and_driven, write_optiodom
from studies.mismatch.worlds.world import (
    AbsentError,
    Label,
    LabelledWorld,
    Request,
    World,
    WrittenWorld,
    drawn,
    write_all,
)

WIDE, CONTACTS = (6, 300), (6, 46)  # cases of the wide world, and of an engine with contacts: quick, whole


def write_engine(folder: Path, request: Request, jobs: int, report: Report) -> Mapping[str, Label]:
    """Write the cases of the independent engine."""
    wanted = {
        f"own-{number:04d}": (case, seed_of(request.seed, number))
        for number, case in enumerate(cases(request.quick))
        if not request.healthy or case.kind == "null"
    }
    return write_all(make, drawn(wanted, request), folder, jobs, report)


def write_drawn(
    module: str,
    counts: tuple[int, int],
    library: str,
    folder: Path,
    request: Request,
    jobs: int,
    report: Report,
) -> Mapping[str, Label]:
    """Write cases that depend on seed and number alone."""
    if find_spec(library) is None:
        raise AbsentError(
            f"{library} is not installed (the extra `{folder.name}`): {folder.name} is left out"
        )
    count = request.cases or counts[0 if request.quick else 1]
    made = {f"{folder.name}-{number:04d}": (request.seed, number) for number in range(count)}
    write_one = import_module(f"studies.mismatch.engines.{module}").make
    return write_all(partial(write_one, faultless=request.healthy), made, folder, jobs, report)


LABELLED = ("concealed", "concealed2", "contact", "contact2", "unnamed")  # folders of recordings with labels


def worlds(data: Path) -> dict[str, World]:
    """Return all worlds by name; `data` is the folder of labelled sets and of real recordings."""
    every: tuple[World, ...] = (
        WrittenWorld("engine", "own engine", write_engine),
        WrittenWorld("wide", "own engine, wide", partial(write_drawn, "wide.cases", WIDE, "numpy")),
        WrittenWorld("mujoco", "MuJoCo", partial(write_drawn, "mujoco.cases", CONTACTS, "mujoco")),
        *(LabelledWorld(name, name, data / name, foreign=True) for name in LABELLED),
        WrittenWorld(
            "bullet", "PyBullet", partial(write_drawn, "bullet.cases", CONTACTS, "pybullet"), foreign=True
        ),
        WrittenWorld("injections", "injections", partial(write_injections, data)),
        WrittenWorld("optiodom", "OptiOdom", partial(write_optiodom, data), ask=diagnosed_and_driven),
    )
    return {world.name: world for world in every}


def chosen(data: Path, names: Sequence[str]) -> list[World]:
    """Return the worlds of these names, all of them where none is given; OmnimateError for another name."""
    every = worlds(data)
    for name in names:
        if name not in every:
            raise OmnimateError(f"no world {name!r}; expected {', '.join(every)}")
    return [every[name] for name in names or every]
