"""The corpus: which faults are concealed in which drives of which robots, and their labels.

Labels are written apart from the recordings. `python -m proof.corpus OUT [--quick]` writes both.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from proof.drives import programme
from proof.engine import Floor, drive
from proof.faults import Fault
from proof.robots import random_robot
from proof.writing import write

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.random import Generator
    from numpy.typing import NDArray

    from proof.engine import Drive

    Array = NDArray[np.float64]

START = 1_763_000_000.0
SEEDS = 1_000_000  # that start at a time of their own: a log's clock has ten digits before the point

# What each effect is made with: bounds of size, as robots in use show them, far enough above the noise.
SIZES: dict[str, dict[str, tuple[float, float]]] = {
    "wheel_diameter": {"ratio": (0.002, 0.006)},
    "wheel_eccentricity": {"amplitude": (2e-4, 8e-4)},
    "radius_vs_speed": {"slope": (0.008, 0.02)},
    "radius_step": {"ratio": (0.003, 0.008)},
    "bump": {"lost": (1.5e-3, 4e-3)},
    "slip_patch": {"fraction": (0.03, 0.1)},
    "traction_slip": {"compliance": (0.05, 0.15)},
    "wheelbase": {"ratio": (0.006, 0.02)},
    "turn_scrub": {"slope": (0.005, 0.015)},
    "wheel_misalignment": {"angle": (0.004, 0.012)},
    "lateral_slip": {"compliance": (0.02, 0.08)},
    "floor_slope": {"rate": (0.004, 0.012)},
    "castor_kick": {"yaw": (0.01, 0.03)},
    "joint_bias": {"bias": (0.004, 0.012)},
    "joint_eccentricity": {"amplitude": (0.004, 0.012)},
    "joint_backlash": {"width": (0.01, 0.03)},
    "link_bias": {"bias": (0.004, 0.012)},
    "link_eccentricity": {"amplitude": (0.003, 0.008)},
    "link_scale": {"ratio": (0.05, 0.15)},
    "count_loss": {"fraction": (0.004, 0.012)},
    "latency": {"delay": (0.03, 0.08)},
    "gear_backlash": {"width": (0.002, 0.006)},
    "gear_harmonic": {"amplitude": (2e-4, 5e-4)},
    "clock_drift": {"rate": (3e-4, 8e-4)},
}
RATIOS = {"wheel_diameter", "radius_step", "wheelbase", "link_scale"}
SIGNED = {"radius_vs_speed", "wheel_misalignment", "castor_kick", "joint_bias", "link_bias"}
UNITS = {
    "ratio": "1", "amplitude": "m", "phase": "rad", "slope": "1", "time": "s", "times": "s", "lost": "m",
    "fraction": "1", "compliance": "s", "angle": "rad", "rate": "1", "direction": "rad", "yaw": "rad",
    "bias": "rad", "width": "rad", "above": "m/s", "delay": "s", "order": "1",
}  # fmt: skip
WHEELED = {
    "wheel_diameter", "wheel_eccentricity", "radius_vs_speed", "radius_step", "bump", "slip_patch",
    "traction_slip",
    "count_loss", "gear_backlash", "gear_harmonic",
}  # fmt: skip
OF_TRUCKS = {"wheelbase", "turn_scrub", "wheel_misalignment", "lateral_slip", "floor_slope", "castor_kick"}
JOINTS = ("joint_a", "joint_b")
OF_JOINTS = {"joint_bias", "joint_eccentricity", "joint_backlash"}
STRANGE: dict[str, tuple[str, ...]] = {
    "slabs": ("left", "right"),
    "warming": ("a.left", "b.right"),
    "hum": ("a.right", "b.left"),
    "pushes": ("a", "b"),
    "magnet": ("b",),
    "tiring": ("a",),
    "crosstalk": ("joint_a", "joint_b"),
    "sag": ("link",),
}
# What a drive may not tell apart, by judgement: a right answer names the effect or one of these.
ALIKE: dict[str, tuple[str, ...]] = {
    "wheel_diameter": ("radius_vs_speed", "count_loss", "radius_step"),
    "radius_vs_speed": ("wheel_diameter", "count_loss"),
    "count_loss": ("wheel_diameter", "radius_vs_speed"),
    "radius_step": ("slip_patch", "wheel_diameter"),
    "slip_patch": ("radius_step", "bump"),
    "bump": ("slip_patch",),
    "wheelbase": ("turn_scrub",),
    "turn_scrub": ("wheelbase",),
    "traction_slip": ("latency",),
    "castor_kick": ("gear_backlash",),
    "gear_backlash": ("castor_kick",),
    "joint_bias": ("wheel_misalignment", "joint_eccentricity"),
    "wheel_misalignment": ("joint_bias", "joint_eccentricity"),
    "joint_eccentricity": ("joint_bias", "wheel_misalignment"),
    "link_bias": ("link_eccentricity", "link_scale"),
    "link_eccentricity": ("link_bias", "link_scale"),
    "link_scale": ("link_bias", "link_eccentricity"),
    "latency": ("traction_slip", "clock_drift", "joint_backlash"),
    "clock_drift": ("latency",),
    "joint_backlash": ("latency",),
    "lateral_slip": ("wheel_misalignment",),
    "floor_slope": (),
    "wheel_eccentricity": ("gear_harmonic",),
    "gear_harmonic": (),
}


@dataclass(frozen=True, slots=True)
class Case:
    """One case of the corpus.

    Attributes:
        kind: null, single, multi, masked, unknown or insufficient.
        effects: (effect, component) that are concealed.
        drive: squares, eights, slalom or shuttle.
        poses: none, sonar or mocap.
        trucks: 1 or 2.
        note: what is special about it.
    """

    kind: str
    effects: tuple[tuple[str, str], ...]
    drive: str
    poses: str
    trucks: int = 2
    note: str = ""


def cases(quick: bool) -> list[Case]:
    """Return the corpus' cases, in an order that does not depend on chance."""
    found = [*_nulls(24 if quick else 300), *_singles(quick), *_multi(quick), *_masked(), *_strange(quick)]
    found += [Case("insufficient", (), "squares", "none", note="short")] * (1 if quick else 6)
    return found


def _nulls(count: int) -> Iterator[Case]:
    kinds, poses = ("squares", "eights", "slalom", "shuttle"), ("none", "sonar", "mocap")
    notes = ("", "noisier poses", "rough floor", "dropped frames", "smooth floor", "waves")
    for number in range(count):
        trucks = 1 if number % 5 == 4 else 2
        seen = poses[number % 3] if trucks == 2 else ("sonar", "mocap")[number % 2]
        yield Case("null", (), kinds[number % 4], seen, trucks, notes[(number // 4) % 6])


def _components(effect: str) -> tuple[str, ...]:
    if effect in WHEELED:
        return ("a.left", "a.right", "b.left", "b.right")
    if effect in OF_TRUCKS:
        return ("a", "b")
    if effect in OF_JOINTS:
        return JOINTS
    return JOINTS if effect in {"latency", "clock_drift"} else ("link",)


def _best_drive(effect: str, number: int) -> str:
    if effect in {"castor_kick", "gear_backlash"}:
        return "shuttle"
    if effect in {"joint_backlash", "latency", "clock_drift", "link_eccentricity", "joint_eccentricity"}:
        return ("slalom", "eights")[number % 2]
    return ("squares", "slalom", "eights")[number % 3]


def _singles(quick: bool) -> Iterator[Case]:
    for place, effect in enumerate(SIZES):
        components = _components(effect)
        for number in range(1 if quick else 12):
            poses = ("sonar", "mocap", "none")[(place + number) % 3]
            if effect == "floor_slope":
                poses = "mocap"
            component = components[(place + number) % len(components)]
            yield Case("single", ((effect, component),), _best_drive(effect, number), poses)


def _multi(quick: bool) -> Iterator[Case]:
    chance = np.random.default_rng(11)
    names = [name for name in SIZES if name not in {"floor_slope", "clock_drift"}]
    for number in range(6 if quick else 90):
        count = 3 if number % 5 == 4 else 2
        picked: dict[str, str] = {}
        while len(picked) < count:
            effect = str(chance.choice(names))
            component = str(chance.choice(_components(effect)))
            near = {other for other in picked if other in ALIKE[effect] or effect in ALIKE[other]}
            if effect not in picked and not near and component not in picked.values():
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


def _strange(quick: bool) -> Iterator[Case]:
    for number in range(1 if quick else 8):
        for kind, components in STRANGE.items():
            component = components[number % len(components)]
            yield Case(
                "unknown",
                (("unknown", component),),
                ("slalom", "eights" if kind == "magnet" else "squares", "eights")[number % 3],
                ("mocap", "sonar")[number % 2],
                note=kind,
            )


def make(folder: Path, case: Case, seed: int) -> dict[str, Any]:
    """Write one case's recording into a folder `1`, and return its label."""
    chance = np.random.default_rng([seed, 77])
    robot = random_robot(chance, case.trucks)
    start = START + 1000.0 * (seed % SEEDS)
    laps = programme(chance, "squares" if case.drive == "one way" else case.drive, 4)
    if case.drive == "one way":
        laps = [laps[0]] * 4
    if case.note == "short":
        laps = [("none", laps[0][1][:1])]
    faults, labels = [], []
    length = sum(duration for _, legs in laps for _, _, duration in legs) + 2.5 * len(laps)
    for effect, component in case.effects:
        parameters = _drawn(chance, effect, start, length, case)
        faults.append(Fault(effect, component, {**parameters, "radius": robot.radius[0], "start": start}))
        labels.append(_label(effect, component, parameters))
    roughness, wave = float(chance.uniform(2e-4, 5e-4)), 0.0 if chance.random() < 0.5 else 0.12
    roughness *= {"rough floor": 2.5, "smooth floor": 0.3}.get(case.note, 1.0)
    wave = 0.15 if case.note == "waves" else wave
    driven: Drive = drive(robot, laps, faults, Floor(roughness, wave), start, chance)
    for label in labels:
        if label["effect"] == "bump":
            _feel(label, driven.time, driven.counts[:, robot.channels.index(label["component"])])
    noise = 2.0 if case.note == "noisier poses" else 1.0
    write(
        folder / "1", robot, driven, case.poses, noise, 0.01 if case.note == "dropped frames" else 0.0, chance
    )
    verdict = {"null": ["agreement"], "insufficient": ["insufficient"]}.get(case.kind, ["mismatch"])
    return {
        "kind": case.kind, "verdict": verdict, "poses": case.poses, "recordings": ["1"], "effects": labels,
        "engine": "own", "drive": case.drive, "note": case.note,
    }  # fmt: skip


def _drawn(chance: Generator, effect: str, start: float, length: float, case: Case) -> dict[str, Any]:
    """Return the parameters of a fault, drawn by chance."""
    if effect == "unknown":
        return _strange_size(chance, case.note, start, length)
    name, (low, high) = next(iter(SIZES[effect].items()))
    size = float(chance.uniform(low, high))
    sign = -1.0 if chance.random() < 0.5 else 1.0
    size, sign = _CONCEALED.get((case.note, effect), (size, sign))
    if effect == "bump":
        count = 1 if case.note == "one bump" else 8
        times = np.sort(start + length * (np.arange(count) + chance.uniform(0.2, 0.8, count)) / count)
        return {"times": times.tolist(), "lost": [size] * count}
    value = 1.0 + sign * size if effect in RATIOS else sign * size if effect in SIGNED else size
    return {name: value, **_more(chance, effect, start, length)}


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
    found: dict[str, dict[str, Any]] = {
        "floor_slope": {"direction": float(chance.uniform(-3.1, 3.1))},
        "radius_step": {"time": start + float(chance.uniform(0.35, 0.65)) * length},
        "count_loss": {"above": 0.3},
        "slip_patch": {"intervals": [[first, first + float(chance.uniform(5.0, 12.0))]]},
        "gear_harmonic": {"order": float(chance.integers(2, 20))},
    }
    waves = {"wheel_eccentricity", "joint_eccentricity", "link_eccentricity", "gear_harmonic"}
    phase = {"phase": float(chance.uniform(-3.1, 3.1))} if effect in waves else {}
    return {**found.get(effect, {}), **phase}


def _strange_size(chance: Generator, kind: str, start: float, length: float) -> dict[str, Any]:
    sizes = {
        "slabs": (6e-4, 0.7), "warming": (0.006, 40.0), "hum": (0.05, 3.7), "pushes": (0.02, 0.0),
        "magnet": (0.02, 0.0), "tiring": (0.05, length), "crosstalk": (0.01, 0.0), "sag": (0.012, 0.0),
    }  # fmt: skip
    size, pitch = sizes[kind]
    times = np.sort(start + length * chance.uniform(0.1, 0.9, 3)).tolist()
    return {"kind": kind, "size": size, "pitch": pitch, "times": times}


def _label(effect: str, component: str, parameters: dict[str, Any]) -> dict[str, Any]:
    intervals = parameters.get("intervals", [])
    if effect == "bump":
        intervals = [[time, time + 0.3] for time in parameters["times"]]
    shown = {
        name: {"value": value, "unit": UNITS.get(name, "")}
        for name, value in parameters.items()
        if name != "intervals" and effect != "unknown"
    }
    alike = [
        {"effect": one, "component": part, "by_judgement": True} for one, part in _alike(effect, component)
    ]
    return {
        "effect": effect,
        "component": component,
        "parameters": shown,
        "intervals": intervals,
        "acceptable": alike,
    }


def _feel(label: dict[str, Any], time: Array, counts: NDArray[np.int64]) -> None:
    """Note in a label when a wheel came to its bumps: one that stands comes to none before it rolls on."""
    rolls = np.diff(counts) != 0
    begins, ends = time[:-1][rolls], time[1:][rolls]
    known = label["parameters"]["times"]
    at = np.searchsorted(ends, known["value"], side="right").clip(max=len(ends) - 1)
    known["value"] = np.maximum(known["value"], begins[at]).tolist()
    label["intervals"] = [[start, start + 0.3] for start in known["value"]]


def _alike(effect: str, component: str) -> Iterator[tuple[str, str]]:
    for other in ALIKE.get(effect, ()):
        same_kind = component in _components(other)
        if same_kind:
            yield other, component
        elif other in OF_JOINTS and component in {"a", "b"}:
            yield other, f"joint_{component}"
        elif other in OF_TRUCKS:
            yield other, component.removeprefix("joint_")[:1]
        elif other == "gear_backlash":
            yield from ((other, f"{component}.left"), (other, f"{component}.right"))


def main() -> None:
    """Write the corpus and its labels."""
    parser = argparse.ArgumentParser(description="Write recordings with concealed effects, and their labels.")
    parser.add_argument("out", type=Path)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    labels = {}
    for number, case in enumerate(cases(options.quick)):
        name = f"{number:04d}"
        labels[name] = make(options.out / name, case, 10_000 * options.seed + number)
    (options.out / "labels.json").write_text(json.dumps(labels, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
