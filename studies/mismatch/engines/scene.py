"""The setting of a case: robot, programme, faults and floor, drawn at random, ready to be driven."""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.random import Generator

from studies.mismatch.engines.engine import Floor, drive
from studies.mismatch.engines.faults import KINDS, ConcealedFault
from studies.mismatch.engines.programmes import Lap, programme
from studies.mismatch.engines.vocabulary import SIGNED, VOCABULARY, WAVES, label
from studies.mismatch.engines.writing import Log, Robot, random_robot

START = 1_763_000_000.0
SEEDS = 1_000_000  # seeds with different start times: the time in a log has ten digits before the point


@dataclass(frozen=True, slots=True)
class Case:
    """One case of the corpus."""

    kind: str  # kind of the case: null, single, multi, masked, unknown or insufficient
    effects: tuple[tuple[str, str], ...]  # effects that are concealed, as (effect, component)
    drive: str  # kind of the drive: squares, one way, eights, slalom or shuttle
    poses: str  # kind of absolute poses: none, sonar or mocap
    trucks: int = 2  # number of trucks, 1 or 2
    note: str = ""  # name of what is special about the case; empty for nothing


@dataclass(frozen=True, slots=True)
class Scene:
    """A robot on a floor before it is driven."""

    robot: Robot  # the robot as its owner believes it to be
    laps: list[Lap]  # laps of its programme
    faults: tuple[ConcealedFault, ...]  # faults that it has
    labels: tuple[dict[str, Any], ...]  # labels of the faults
    floor: Floor  # the floor under its wheels
    start: float  # time of the first sample [s]
    chance: Generator  # source of the floor's scatter and of the sensors' noise

    def fault(self, effect: str, component: str, parameters: dict[str, Any]) -> ConcealedFault:
        """Return a fault of this robot, with the robot's radius and start time beside its parameters."""
        return ConcealedFault(
            effect, component, {**parameters, "radius": self.robot.radius[0], "start": self.start}
        )

    def driven(self, faults: Sequence[ConcealedFault], chance: Generator | None = None) -> Log:
        """Return a drive with faults; every call draws the same random numbers, unless `chance` is given."""
        fresh = [replace(fault, memory={}) for fault in faults]
        return drive(self.robot, self.laps, fresh, self.floor, self.start, chance or deepcopy(self.chance))


def scene(case: Case, seed: int) -> Scene:
    """Return the setting of a case; the same seed gives the same setting."""
    chance = np.random.default_rng([seed, 77])
    robot = random_robot(chance, case.trucks)
    start = START + 1000.0 * (seed % SEEDS)
    laps = programme(chance, "squares" if case.drive == "one way" else case.drive, 4)
    if case.drive == "one way":
        laps = [laps[0]] * 4
    if case.note == "short":
        laps = [("none", laps[0][1][:1])]
    length = sum(duration for _, legs in laps for _, _, duration in legs) + 2.5 * len(laps)
    drawn = [
        (effect, component, drawn_parameters(chance, effect, start, length, case.note))
        for effect, component in case.effects
    ]
    labels = tuple(label(*fault) for fault in drawn)
    roughness, wave = float(chance.uniform(2e-4, 5e-4)), 0.0 if chance.random() < 0.5 else 0.12
    roughness *= {"rough floor": 2.5, "smooth floor": 0.3}.get(case.note, 1.0)
    wave = 0.15 if case.note == "waves" else wave
    healthy = Scene(robot, laps, (), labels, Floor(roughness, wave), start, chance)
    return replace(healthy, faults=tuple(healthy.fault(*fault) for fault in drawn))


def drawn_parameters(
    chance: Generator, effect: str, start: float, length: float, note: str, stretch: float = 1.0
) -> dict[str, Any]:
    """Return the parameters of a fault, drawn at random for a drive of some length [s] from a start [s].

    `note` says what is special, of an unknown effect its kind; `stretch` is a factor on the size.
    """
    if effect == "unknown":
        return _unnamed_physics(chance, note, start, length, stretch)
    own = VOCABULARY[effect]
    size = stretch * float(chance.uniform(*own.concealed))
    sign = -1.0 if chance.random() < 0.5 else 1.0
    size, sign = _CONCEALED.get((note, effect), (size, sign))
    if effect != "bump":
        signed = own.parameter == "ratio" or effect in SIGNED
        return own.sized(sign * size if signed else size, _more(chance, effect, start, length))
    count = 1 if note == "one bump" else 8
    times = np.sort(start + length * (np.arange(count) + chance.uniform(0.2, 0.8, count)) / count)
    return own.sized(size, {"times": times.tolist()})


# Sizes by which effects hide: on clockwise squares a wider wheelbase and a larger right wheel cancel.
_CONCEALED = {
    ("cancel", "wheelbase"): (0.012, -1.0),
    ("cancel", "wheel_diameter"): (0.0036, 1.0),
    ("mutual", "wheel_diameter"): (0.003, 1.0),
    ("small under big", "wheel_diameter"): (0.006, 1.0),
    ("small under big", "wheel_eccentricity"): (2.5e-4, 1.0),
}


def _more(chance: Generator, effect: str, start: float, length: float) -> dict[str, Any]:
    """Return the parameters of a fault beside its size."""
    first = start + float(chance.uniform(0.2, 0.7)) * length
    drawn: dict[str, dict[str, Any]] = {
        "floor_slope": {"direction": float(chance.uniform(-3.1, 3.1))},
        "radius_step": {"time": start + float(chance.uniform(0.35, 0.65)) * length},
        "count_loss": {"above": 0.3},
        "slip_patch": {"intervals": [[first, first + float(chance.uniform(5.0, 12.0))]]},
        "gear_harmonic": {"order": float(chance.integers(2, 20))},
    }
    phase = {"phase": float(chance.uniform(-3.1, 3.1))} if effect in WAVES else {}
    return {**drawn.get(effect, {}), **phase}


def _unnamed_physics(
    chance: Generator, kind: str, start: float, length: float, stretch: float
) -> dict[str, Any]:
    size, pitch = KINDS[kind]
    pitch = length if kind == "tiring" else pitch
    times = np.sort(start + length * chance.uniform(0.1, 0.9, 3)).tolist()
    return {"kind": kind, "size": stretch * size, "pitch": pitch, "times": times}
