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

# Cases of the wide world, of its physics without a name, and of an engine with contacts: quick, whole
WIDE, NAMELESS, CONTACTS = (6, 300), (3, 60), (6, 46)


def write_engine(folder: Path, request: Request, jobs: int, report: Report) -> Mapping[str, Label]:
    """Write the cases of the independent engine."""
    wanted = {
        f"own-{number:04d}": (case, seed_of(request.seed, number))
        for number, case in enumerate(cases(request.quick))
        if not request.healthy or case.kind == "null"
    }
    return write_all(make, drawn(wanted, request), folder, jobs, report)


LABELLED = ("concealed", "concealed2", "contact", "contact2", "unnamed")  # folders of recordings with labels


def worlds(data: Path) -> dict[str, World]:
    """Return all worlds by name; `data` is the folder of labelled sets and of real recordings."""
    every: tuple[World, ...] = (
        WrittenWorld("engine", "own engine", write_engine),
        _drawn("wide", "own engine, wide", "wide.cases.make", WIDE, "numpy"),
        _drawn("nameless", "own engine, nameless", "wide.cases.make_nameless", NAMELESS, "numpy"),
        _drawn("mujoco", "MuJoCo", "mujoco.cases.make", CONTACTS, "mujoco"),
        *(LabelledWorld(name, name, data / name, foreign=True) for name in LABELLED),
        _drawn("bullet", "PyBullet", "bullet.cases.make", CONTACTS, "pybullet", foreign=True),
        WrittenWorld("injections", "injections", partial(write_injections, data)),
        WrittenWorld("optiodom", "OptiOdom", partial(write_optiodom, data), ask=diagnosed_and_driven),
    )
    return {world.name: world for world in every}


def _drawn(
    name: str, title: str, maker: str, counts: tuple[int, int], library: str, *, foreign: bool = False
) -> WrittenWorld:
    """Return a world of cases that depend on seed and number alone, which a function of an engine makes."""

    def write(folder: Path, request: Request, jobs: int, report: Report) -> Mapping[str, Label]:
        if find_spec(library) is None:
            raise AbsentError(f"{library} is not installed (the extra `{name}`): {name} is left out")
        count = request.cases or counts[0 if request.quick else 1]
        made = {f"{name}-{number:04d}": (request.seed, number) for number in range(count)}
        module, function = f"studies.mismatch.engines.{maker}".rsplit(".", 1)
        write_one = getattr(import_module(module), function)
        return write_all(partial(write_one, faultless=request.healthy), made, folder, jobs, report)

    return WrittenWorld(name, title, write, foreign=foreign)


def chosen(data: Path, names: Sequence[str]) -> list[World]:
    """Return the worlds of these names, all of them where none is given; OmnimateError for another name."""
    every = worlds(data)
    for name in names:
        if name not in every:
            raise OmnimateError(f"no world {name!r}; expected {', '.join(every)}")
    return [every[name] for name in names or every]
