"""Rivals: what other effects would do to the same drives, so that labels can say what looks alike.

Effects of wheels and of the poses come from the laws; those that move a truck sideways, which counts cannot
show, are written as changes of the residual.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimate.proof.injections.drive import SIDES, Drive, increments, rates
from omnimate.proof.injections.laws import altered

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from omnimate.proof.injections.bound import Ruler

    Array = NDArray[np.float64]
    Name = tuple[str, str]

CROSSING = 0.3  # [s] that a wheel takes for a bump, about


def rivals(
    effect: str, more: Mapping[str, Any], drives: Sequence[Drive], ruler: Ruler
) -> dict[Name, list[Array]]:
    """Return the whitened changes `(K,)` by effects of usual size, by (effect, component).

    An effect with a free phase or direction has two changes, which together give every phase.

    Args:
        effect: Effect for which rivals are sought; those that act at moments take its moments.
        more: Its parameters beside its size.
        drives: The untouched drives.
        ruler: Their ruler.
    """
    columns: dict[Name, list[Array]] = {}
    for name, component, parameters in _by_laws(effect, more, drives):
        changed = [altered(drive, name, component, parameters) for drive in drives]
        columns.setdefault((name, component), []).append(ruler.change(changed))
    for name in ("wheel_misalignment", "lateral_slip", "castor_kick", "floor_slope"):
        sideways = [_sideways(name, drive) for drive in drives]
        columns[name, "a"] = [
            ruler.noise.whitened([each[number] for each in sideways]) for number in range(len(sideways[0]))
        ]
    return columns


def _by_laws(
    effect: str, more: Mapping[str, Any], drives: Sequence[Drive]
) -> Iterator[tuple[str, str, dict[str, Any]]]:
    end = float(drives[-1].time[-1])
    first, spans = _moments(effect, more, end)
    above = more.get("above") or float(
        np.median(np.concatenate([np.abs(rates(drive.way[:, 0], drive.time)[0]) for drive in drives]))
    )
    yield "wheelbase", "a", {"ratio": 1.01}
    yield "turn_scrub", "a", {"slope": 0.005}
    yield "traction_slip", "a", {"compliance": 0.05}
    yield "latency", "poses", {"delay": 0.02}
    yield "clock_drift", "poses", {"rate": 5e-4}
    for side in SIDES:
        yield "wheel_diameter", side, {"ratio": 1.003}
        yield "radius_vs_speed", side, {"slope": 0.02}
        yield "count_loss", side, {"fraction": 0.01, "above": above}
        yield "traction_slip", side, {"compliance": 0.05}
        yield "latency", side, {"delay": 0.02}
        yield "gear_backlash", side, {"width": 1e-3}
        for phase in (0.0, 0.5 * math.pi):
            yield "wheel_eccentricity", side, {"amplitude": 3e-4, "phase": phase}
            if "order" in more:
                yield "gear_harmonic", side, {"amplitude": 2e-4, "order": more["order"], "phase": phase}
        if first is not None:
            yield "radius_step", side, {"ratio": 1.005, "time": first}
        if spans:
            times = [start for start, _ in spans]
            yield "slip_patch", side, {"fraction": 0.05, "intervals": spans}
            yield "bump", side, {"times": times, "lost": [2e-3] * len(times)}


def _moments(effect: str, more: Mapping[str, Any], end: float) -> tuple[float | None, list[list[float]]]:
    """Return the moment from which an effect acts, and the intervals in which it does [s]."""
    if effect == "radius_step":
        return more["time"], [[more["time"], end]]
    if effect == "slip_patch":
        return more["intervals"][0][0], more["intervals"]
    if effect == "bump":
        return more["times"][0], [[time, time + CROSSING] for time in more["times"]]
    return None, []


def _sideways(effect: str, drive: Drive) -> list[Array]:
    """Return changes of the residual `(M - 1, 3)` by an effect that moves the truck, in any unit."""
    steps = increments(drive.pose)
    forward, yaw, zero = steps[:, 0], steps[:, 2], np.zeros(len(steps))
    if effect == "wheel_misalignment":
        return [np.stack([zero, forward, zero], axis=1)]
    if effect == "lateral_slip":
        return [np.stack([zero, forward * yaw / np.diff(drive.pose_time), zero], axis=1)]
    if effect == "castor_kick":
        way = 0.5 * drive.way.sum(axis=1)
        speed = np.interp(drive.pose_time, drive.time[1:], rates(way, drive.time)[0])
        runs = np.flatnonzero(np.abs(speed) > 0.01)
        turns = runs[1:][np.diff(np.sign(speed[runs])) != 0.0]
        kicks = zero.copy()
        kicks[np.minimum(turns, len(kicks) - 1)] = 1.0
        return [np.stack([zero, zero, kicks], axis=1)]
    heading, way = drive.pose[:-1, 2], np.abs(forward)
    return [
        np.stack([way * np.cos(turn - heading), way * np.sin(turn - heading), zero], axis=1)
        for turn in (0.0, 0.5 * math.pi)
    ]
