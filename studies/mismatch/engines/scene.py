"""The corpus of the own engine: which faults are concealed in which drives, drawn at random, and recorded."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.random import Generator

from studies.mismatch.engines.engine import Floor, drive
from studies.mismatch.engines.faults import KINDS, ConcealedFault
from studies.mismatch.engines.programmes import Lap, programme
from studies.mismatch.engines.vocabulary import (
    ALIKE,
    SIGNED,
    UNNAMED,
    VOCABULARY,
    WAVES,
    label,
    set_bump_times,
)
from studies.mismatch.engines.writing import MEASURING, Log, Robot, random_robot, write

START = 1_763_000_000.0
SEEDS = 1_000_000  # seeds with different start times: the time in a log has ten digits before the point


@dataclass(frozen=True, slots=True)
class Case:
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
    entry = VOCABULARY[effect]
    size = stretch * float(chance.uniform(*entry.concealed))
    sign = -1.0 if chance.random() < 0.5 else 1.0
    size, sign = _CONCEALED.get((note, effect), (size, sign))
    if effect != "bump":
        signed = entry.parameter == "ratio" or effect in SIGNED
        return entry.sized(sign * size if signed else size, _more(chance, effect, start, length))
    count = 1 if note == "one bump" else 8
    times = np.sort(start + length * (np.arange(count) + chance.uniform(0.2, 0.8, count)) / count)
    return entry.sized(size, {"times": times.tolist()})


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


def seed_of(seed: int, number: int) -> int:
    """Return the seed of case `number` in the corpus of a seed."""
    return 10_000 * seed + number


def cases(quick: bool) -> list[Case]:
    """Return the cases of the corpus, the small one where `quick`, in a fixed order."""
    corpus = [*_nulls(24 if quick else 300), *_singles(quick), *_multi(quick), *_masked(), *_unknown(quick)]
    corpus += [Case("insufficient", (), "squares", "none", note="short")] * (1 if quick else 6)
    return corpus


def _nulls(count: int) -> Iterator[Case]:
    kinds, poses = ("squares", "eights", "slalom", "shuttle"), ("none", "sonar", "mocap")
    notes = ("", "noisier poses", "rough floor", "dropped frames", "smooth floor", "waves")
    for number in range(count):
        trucks = 1 if number % 5 == 4 else 2
        measured = poses[number % 3] if trucks == 2 else ("sonar", "mocap")[number % 2]
        yield Case("null", (), kinds[number % 4], measured, trucks, notes[(number // 4) % 6])


def _best_drive(effect: str, number: int) -> str:
    if effect in {"castor_kick", "gear_backlash"}:
        return "shuttle"
    if effect in {"joint_backlash", "latency", "clock_drift", "link_eccentricity", "joint_eccentricity"}:
        return ("slalom", "eights")[number % 2]
    return ("squares", "slalom", "eights")[number % 3]


def _singles(quick: bool) -> Iterator[Case]:
    for place, effect in enumerate(VOCABULARY):
        places = VOCABULARY[effect].components
        for number in range(1 if quick else 12):
            poses = ("sonar", "mocap", "none")[(place + number) % 3]
            if effect == "floor_slope":
                poses = "mocap"
            component = places[(place + number) % len(places)]
            yield Case("single", ((effect, component),), _best_drive(effect, number), poses)


def _multi(quick: bool) -> Iterator[Case]:
    chance = np.random.default_rng(11)
    names = [name for name in VOCABULARY if name not in {"floor_slope", "clock_drift"}]
    for number in range(6 if quick else 90):
        count = 3 if number % 5 == 4 else 2
        picked: dict[str, str] = {}
        while len(picked) < count:
            effect = str(chance.choice(names))
            component = str(chance.choice(VOCABULARY[effect].components))
            alike = {other for other in picked if other in ALIKE[effect] or effect in ALIKE[other]}
            if effect not in picked and not alike and component not in picked.values():
                picked[effect] = component
        reverses = any(effect in {"castor_kick", "gear_backlash"} for effect in picked)
        kind = "shuttle" if reverses else ("slalom", "squares", "eights")[number % 3]
        yield Case("multi", tuple(picked.items()), kind, ("mocap", "sonar", "none")[number % 3])


def _masked() -> Iterator[Case]:
    yield Case("masked", (("wheelbase", "a"), ("wheel_diameter", "a.right")), "one way", "sonar", 2, "cancel")
    yield Case("masked", (("wheelbase", "a"), ("wheel_diameter", "a.right")), "one way", "mocap", 1, "cancel")
    yield Case(
        "masked", (("wheel_diameter", "a.left"), ("wheel_diameter", "b.left")), "squares", "none", 2, "mutual"
    )
    yield Case("masked", (("bump", "b.left"),), "squares", "none", 2, "one bump")
    yield Case("masked", (("slip_patch", "a.right"),), "slalom", "sonar", 2, "one lap")
    yield Case(
        "masked",
        (("wheel_diameter", "a.left"), ("wheel_eccentricity", "b.right")),
        "eights",
        "sonar",
        2,
        "small under big",
    )


def _unknown(quick: bool) -> Iterator[Case]:
    for number in range(1 if quick else 8):
        for kind, places in UNNAMED.items():
            component = places[number % len(places)]
            yield Case(
                "unknown",
                (("unknown", component),),
                ("slalom", "eights" if kind == "magnet" else "squares", "eights")[number % 3],
                ("mocap", "sonar")[number % 2],
                note=kind,
            )


def make(folder: Path, case: Case, seed: int) -> dict[str, Any]:
    """Write the recording of a case into the subfolder `1`, and return its label."""
    setting = scene(case, seed)
    robot = setting.robot
    driven = setting.driven(setting.faults, setting.chance)
    labels = list(setting.labels)
    for effect in labels:
        if effect["effect"] == "bump":
            set_bump_times(effect, driven.time, driven.counts[:, robot.channels.index(effect["component"])])
    measuring = MEASURING[case.poses]
    if measuring is not None and case.note == "noisier poses":
        measuring = replace(measuring, noise=2.0)
    dropped = 0.01 if case.note == "dropped frames" else 0.0
    write(folder / "1", robot, driven, measuring, dropped, setting.chance)
    verdict = {"null": ["agreement"], "insufficient": ["insufficient"]}.get(case.kind, ["mismatch"])
    return {
        "kind": case.kind, "verdict": verdict, "poses": case.poses, "recordings": ["1"], "effects": labels,
        "engine": "own", "drive": case.drive, "note": case.note,
    }  # fmt: skip
