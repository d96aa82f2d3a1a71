"""The corpus of the own engine: which faults are concealed in which drives, and their recordings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from studies.mismatch.engines.scene import Case, scene
from studies.mismatch.engines.vocabulary import ALIKE, UNNAMED, VOCABULARY, set_bump_times
from studies.mismatch.engines.writing import MEASURING, write


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
    for label in labels:
        if label["effect"] == "bump":
            set_bump_times(label, driven.time, driven.counts[:, robot.channels.index(label["component"])])
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
