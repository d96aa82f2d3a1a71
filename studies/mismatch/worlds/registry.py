"""All worlds, by name."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from omnimate.vehicle.errors import OmnimateError
from studies.mismatch.worlds.engines import write_bullet, write_engine, write_mujoco, write_wide
from studies.mismatch.worlds.injections import write_injections
from studies.mismatch.worlds.optiodom import diagnosed_and_driven, write_optiodom
from studies.mismatch.worlds.world import LabelledWorld, World, WrittenWorld

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path


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
