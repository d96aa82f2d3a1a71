"""Two drives of one robot with one concealed effect: one to learn from, and one that nothing has seen."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimate.effects import effect_named
from omnimate.files.recordings.folder import load_recording
from studies.mismatch.engines.cases import cases, seed_of
from studies.mismatch.engines.labels import label, set_bump_times
from studies.mismatch.engines.scene import scene
from studies.mismatch.engines.writing import MEASURING, write

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from omnimate.effects.effect import Effect
    from omnimate.vehicle.recording import Recording
    from studies.mismatch.engines.cases import Case

QUICK = ("wheelbase", "radius_vs_speed", "joint_eccentricity")  # effects of the small study


@dataclass(frozen=True, slots=True)
class Pair:
    """Two drives of a robot along the same programme; floor and sensors scatter anew in each.

    Attributes:
        effect: The effect that is concealed in both, as the library describes it.
        seen: The drive to learn from.
        unseen: The drive that no fit sees.
    """

    effect: Effect
    seen: Recording
    unseen: Recording


def wanted(count: int, seed: int, *, quick: bool = False) -> Iterator[tuple[Case, int]]:
    """Yield cases of the corpus that conceal one effect, some of each effect, with their seeds.

    Poses are dense: where a recording hardly shows an effect, no law of it can be learned.

    Args:
        count: Cases of each effect, at most.
        seed: Seed of the corpus.
        quick: Whether a few effects will do.
    """
    taken: dict[str, int] = {}
    for number, case in enumerate(cases(quick=False)):
        if case.kind != "single":
            continue
        name = case.effects[0][0]
        taken[name] = taken.get(name, 0) + 1
        if taken[name] <= count and (not quick or name in QUICK):
            yield replace(case, poses="mocap"), seed_of(seed, number)


def pair(folder: Path, case: Case, seed: int) -> Pair:
    """Write and load the two drives of a case."""
    setting = scene(case, seed)
    (fault,) = setting.faults
    parameters = {name: value for name, value in fault.parameters.items() if name not in {"radius", "start"}}
    named = label(fault.effect, fault.component, parameters)
    recordings = []
    for number in (1, 2):
        chance = np.random.default_rng([seed, 78, number])
        driven = setting.driven(setting.faults, chance)
        write(folder / str(number), setting.robot, driven, MEASURING[case.poses], 0.0, chance)
        recordings.append(load_recording(folder / str(number)))
        if fault.effect == "bump" and number == 1:
            column = setting.robot.channels.index(fault.component)
            set_bump_times(named, driven.time, driven.counts[:, column])
            parameters["times"] = named["parameters"]["times"]["value"]
    values = {name: _frozen(value) for name, value in parameters.items()}
    return Pair(effect_named(fault.effect)(component=fault.component, **values), *recordings)


def _frozen(value: Any) -> Any:  # noqa: ANN401  # a number, or lists of them
    return tuple(map(_frozen, value)) if isinstance(value, list) else value
