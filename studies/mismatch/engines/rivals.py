"""Effects that look like another one in the same drives, and effects of a drawn strength to inject."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.random import Generator

from studies.mismatch.engines.laws import altered
from studies.mismatch.engines.strength import Drive, Ruler, left_of
from studies.mismatch.engines.vocabulary import (
    LINKAGE,
    SIGNED,
    TRUCKS,
    VOCABULARY,
    WAVES,
    WHEELS,
    Array,
    label,
)

Name = tuple[str, str]

CROSSING = 0.3  # [s] that a wheel takes for a bump, about
QUARTERS = (0.0, 0.5 * math.pi)  # phases of which any other is a sum
# Standard deviations up to which another effect looks like the one that acts: a likelihood ratio of
# exp(3^2 / 2) = 90 takes a name out of the 95 % set.
SEPARATE = 3.0


def alike(
    change: Array, effect: str, component: str, more: Mapping[str, Any], drives: Sequence[Drive], ruler: Ruler
) -> dict[Name, float]:
    """Return the effects that drives cannot tell from one, and the standard deviations that separate them.

    `change` is the whitened change by the effect, shape `(K,)`; `more` its parameters other than its size, as
    rivals that act at moments take its moments.
    """
    columns = rivals(effect, more, drives, ruler)
    apart = {
        name: left_of(change, change_of) for name, change_of in columns.items() if name != (effect, component)
    }
    return {name: left for name, left in apart.items() if left < SEPARATE}


def measured_label(
    effect: str, component: str, parameters: Mapping[str, Any], strength: float, others: Mapping[Name, float]
) -> dict[str, Any]:
    """Return the label of an effect of some strength, with the others that `alike` gives."""
    acceptable = [
        {"effect": name, "component": place, "separation": round(apart, 2)}
        for (name, place), apart in others.items()
    ]
    known = {"sigmas_above_noise": round(strength, 2), "acceptable": acceptable}
    return {**label(effect, component, parameters), **known}


def rivals(
    effect: str, more: Mapping[str, Any], drives: Sequence[Drive], ruler: Ruler
) -> dict[Name, list[Array]]:
    """Return the whitened changes `(K,)` by effects of usual size, by (effect, component).

    An effect with a free phase or direction has two changes, which together give every phase. The arguments
    are those of `alike`.
    """
    columns: dict[Name, list[Array]] = {}
    for name, component, parameters in _usual(effect, more, drives):
        changed = [altered(drive, name, component, parameters) for drive in drives]
        columns.setdefault((name, component), []).append(ruler.change(changed))
    return columns


def _usual(
    effect: str, more: Mapping[str, Any], drives: Sequence[Drive]
) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Yield effects, components, and parameters of usual size."""
    components = {*TRUCKS[: drives[0].trucks], *WHEELS[: 2 * drives[0].trucks]}
    components |= set(LINKAGE) if drives[0].trucks == 2 else set()
    components |= {"poses"} if any(drive.poses for drive in drives) else set()
    for name, rival in VOCABULARY.items():
        for component in (*rival.components, *_MORE_PLACES.get(name, ())):
            for others in _others(name, component, effect, more, drives) if component in components else ():
                yield name, component, rival.sized(rival.usual, others)


# Components on which effects act that the own engine does not conceal there.
_MORE_PLACES = {
    "traction_slip": TRUCKS,
    "latency": ("poses", *WHEELS, "link"),
    "clock_drift": ("poses", "link"),
}


def _others(
    name: str, component: str, effect: str, more: Mapping[str, Any], drives: Sequence[Drive]
) -> list[dict[str, Any]]:
    """Return the parameters of a rival other than its size: none where it cannot act, two for any phase."""
    first, spans = _times_of(effect, more, float(drives[-1].time[-1]))
    if name in WAVES:
        order = {"order": more.get("order")} if name == "gear_harmonic" else {}
        return [] if None in order.values() else [{**order, "phase": phase} for phase in QUARTERS]
    if name == "count_loss":
        speeds = np.concatenate([drive.speed(WHEELS.index(component)) for drive in drives])
        return [{"above": more.get("above") or float(np.median(speeds))}]
    others: dict[str, list[dict[str, Any]]] = {
        "floor_slope": [{"direction": direction} for direction in QUARTERS],
        "radius_step": [] if first is None else [{"time": first}],
        "slip_patch": [{"intervals": spans}] if spans else [],
        "bump": [{"times": [start for start, _ in spans]}] if spans else [],
    }
    return others.get(name, [{}])


def _times_of(effect: str, more: Mapping[str, Any], end: float) -> tuple[float | None, list[list[float]]]:
    """Return the moment from which an effect acts, and the intervals in which it does [s]."""
    if effect == "radius_step":
        return more["time"], [[more["time"], end]]
    if effect == "slip_patch":
        return more["intervals"][0][0], more["intervals"]
    if effect == "bump":
        return more["times"][0], [[time, time + CROSSING] for time in more["times"]]
    return None, []


WEAKEST, STRONGEST = 1.0, 30.0  # standard deviations above the noise, drawn log-uniformly
SIDES = WHEELS[:2]  # of the one truck that injections know
MOVING = 0.03  # [m/s]
ATTEMPTS = 60  # draws of an effect that this drive can show at a size that a robot can have
# The largest size that a robot can have, of the effects that are injected.
LARGEST = {
    "wheel_diameter": 0.05, "wheelbase": 0.1, "turn_scrub": 0.05, "radius_step": 0.1,
    "wheel_eccentricity": 4e-3, "radius_vs_speed": 0.3, "slip_patch": 0.6, "bump": 0.015, "count_loss": 0.3,
    "latency": 0.4, "clock_drift": 0.01, "gear_backlash": 0.01, "gear_harmonic": 3e-3, "traction_slip": 0.6,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Injection:
    effect: str  # name of the effect in the vocabulary
    component: str  # component on which it acts
    size: float  # its size, with its sign
    more: dict[str, Any]  # its other parameters, by name

    @property
    def parameters(self) -> dict[str, Any]:
        """All parameters by name, in SI units."""
        return VOCABULARY[self.effect].sized(self.size, self.more)

    def into(self, drives: Sequence[Drive]) -> list[Drive]:
        """Return drives as a robot with the effect would have recorded them."""
        return [altered(drive, self.effect, self.component, self.parameters) for drive in drives]


@dataclass(frozen=True, slots=True)
class Strong:
    injection: Injection  # what is injected
    strength: float  # standard deviations by which it stands above the noise, nuisances estimated with it
    # other effects by (effect, component), and the standard deviations that tell them from it; those that
    # this drive cannot tell apart
    alike: dict[tuple[str, str], float]

    def label(self) -> dict[str, Any]:
        """Return the label of the effect, as `labels.json` holds it."""
        put = self.injection
        return measured_label(put.effect, put.component, put.parameters, self.strength, self.alike)


def draw(drives: Sequence[Drive], ruler: Ruler, chance: Generator) -> Strong | None:
    """Return an injection into drives of one robot; None where they can show no effect."""
    for _ in range(ATTEMPTS):
        effect = str(chance.choice(list(LARGEST)))
        wanted = math.exp(chance.uniform(math.log(WEAKEST), math.log(STRONGEST)))
        entry = VOCABULARY[effect]
        signed = entry.parameter == "ratio" or effect in {*SIGNED, "clock_drift"}
        sign = -1.0 if signed and chance.random() < 0.5 else 1.0
        component = str(chance.choice(_components(effect)))
        injection = Injection(effect, component, sign * entry.usual, _more(effect, component, drives, chance))
        for _ in range(3):  # the change is not quite in proportion to the size
            strength = strength_of(injection, drives, ruler)
            if strength == 0.0 or abs(injection.size) * wanted / strength > LARGEST[effect]:
                break
            injection = replace(injection, size=injection.size * wanted / strength)
        else:
            strength = strength_of(injection, drives, ruler)
            change = ruler.change(injection.into(drives))
            others = alike(change, effect, component, injection.more, drives, ruler)
            return Strong(injection, strength, others)
    return None


def strength_of(injection: Injection, drives: Sequence[Drive], ruler: Ruler) -> float:
    """Return by how many standard deviations an injection stands above the noise.

    The three numbers of a calibration are estimated with it, and the phase of a wave; times, places and
    thresholds are taken as known.
    """
    nuisances = ruler.nuisances(drives, injection.effect, injection.component)
    if injection.effect in WAVES:
        turned = {**injection.more, "phase": injection.more["phase"] + 0.5 * math.pi}
        nuisances.append(ruler.change(replace(injection, more=turned).into(drives)))
    return left_of(ruler.change(injection.into(drives)), nuisances)


def _components(effect: str) -> tuple[str, ...]:
    if effect in {"wheelbase", "turn_scrub"}:
        return ("a",)
    if effect == "clock_drift":
        return ("poses",)
    return {"latency": (*SIDES, "poses"), "traction_slip": (*SIDES, "a")}.get(effect, SIDES)


def _more(effect: str, component: str, drives: Sequence[Drive], chance: Generator) -> dict[str, Any]:
    """Return the parameters of an effect other than its size."""
    if effect in {"wheel_eccentricity", "gear_harmonic"}:
        phase = {"phase": float(chance.uniform(-math.pi, math.pi))}
        return phase if effect == "wheel_eccentricity" else {"order": float(chance.integers(2, 7)), **phase}
    if effect == "radius_step":
        start, end = drives[0].time[0], drives[-1].time[-1]
        return {"time": float(start + chance.uniform(0.3, 0.7) * (end - start))}
    if effect == "count_loss":
        speeds = np.concatenate([drive.speed(SIDES.index(component)) for drive in drives])
        return {"above": float(np.quantile(speeds[speeds > MOVING], chance.uniform(0.3, 0.7)))}
    if effect == "bump":
        moments = _moments(drives, SIDES.index(component))
        times = np.sort(chance.choice(moments, int(chance.integers(1, 9)), replace=False))
        apart = np.concatenate(([True], np.diff(times) > 2.0))
        return {"times": [float(time) for time in times[apart]]}
    if effect == "slip_patch":
        region = chance.random() < 0.5
        return {"intervals": _crossed(drives, chance) if region else _stretch(drives, component, chance)}
    return {}


def _moments(drives: Sequence[Drive], wheel: int) -> Array:
    """Return the times at which a wheel moves [s]."""
    return np.concatenate([drive.time[1:][drive.speed(wheel) > MOVING] for drive in drives])


def _stretch(drives: Sequence[Drive], component: str, chance: Generator) -> list[list[float]]:
    """Return an interval of 3 to 10 s that begins while the wheel moves."""
    start = float(chance.choice(_moments(drives, SIDES.index(component))))
    return [[start, start + float(chance.uniform(3.0, 10.0))]]


def _crossed(drives: Sequence[Drive], chance: Generator) -> list[list[float]]:
    """Return the intervals in which the robot is on a round region of the floor, somewhere on its path."""
    drive = drives[int(chance.integers(len(drives)))]
    centre = drive.poses[0].pose[int(chance.integers(len(drive.poses[0].pose))), :2]
    radius = float(chance.uniform(0.15, 0.5))
    intervals = []
    for poses in (single_drive.poses[0] for single_drive in drives):
        within = np.hypot(*(poses.pose[:, :2] - centre).T) < radius
        edges = np.flatnonzero(np.diff(np.concatenate(([0], within.astype(int), [0]))))
        intervals += [
            [float(poses.time[first]), float(poses.time[last - 1])]
            for first, last in edges.reshape(-1, 2)
            if last - first > 1
        ]
    return intervals
