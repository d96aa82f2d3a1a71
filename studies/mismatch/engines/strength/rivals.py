"""Rivals: what other effects would do to the same drives, so that labels can say what looks alike."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from studies.mismatch.engines.strength.bound import left_of
from studies.mismatch.engines.strength.drive import TRUCKS, WHEELS, Drive, rates
from studies.mismatch.engines.strength.laws import altered

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from studies.mismatch.engines.strength.bound import Ruler

    Array = NDArray[np.float64]
    Name = tuple[str, str]

CROSSING = 0.3  # [s] that a wheel takes for a bump, about
QUARTERS = (0.0, 0.5 * math.pi)  # phases of which any other is a sum
# Standard deviations up to which another effect looks like the one that acts: a likelihood ratio of
# exp(3^2 / 2) = 90 takes a name out of the 95 % set.
SEPARATE = 3.0


def alike(
    change: Array, effect: str, component: str, more: Mapping[str, Any], drives: Sequence[Drive], ruler: Ruler
) -> dict[Name, float]:
    """Return the effects that drives cannot tell from one, and the standard deviations that would tell them.

    Args:
        change: Whitened change `(K,)` by the effect.
        effect: The effect.
        component: Component on which it acts.
        more: Its parameters beside its size: rivals that act at moments take its moments.
        drives: The untouched drives.
        ruler: Their ruler.
    """
    columns = rivals(effect, more, drives, ruler)
    apart = {name: left_of(change, own) for name, own in columns.items() if name != (effect, component)}
    return {name: left for name, left in apart.items() if left < SEPARATE}


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
    drive = drives[0]
    if any(each.poses for each in drives):
        yield "latency", "poses", {"delay": 0.02}
        yield "clock_drift", "poses", {"rate": 5e-4}
    for truck in TRUCKS[: drive.trucks]:
        yield from _of_truck(truck)
    first, spans = _moments(effect, more, float(drives[-1].time[-1]))
    for number, wheel in enumerate(WHEELS[: 2 * drive.trucks]):
        yield from _of_wheel(wheel, more.get("above") or _usual_speed(drives, number), more.get("order"))
        if first is not None:
            yield "radius_step", wheel, {"ratio": 1.005, "time": first}
        if spans:
            times = [start for start, _ in spans]
            yield "slip_patch", wheel, {"fraction": 0.05, "intervals": spans}
            yield "bump", wheel, {"times": times, "lost": [2e-3] * len(times)}
    if drive.trucks == 2:
        yield from _of_linkage()


def _of_truck(truck: str) -> Iterator[tuple[str, str, dict[str, Any]]]:
    yield "wheelbase", truck, {"ratio": 1.01}
    yield "turn_scrub", truck, {"slope": 0.005}
    yield "traction_slip", truck, {"compliance": 0.05}
    yield "wheel_misalignment", truck, {"angle": 0.005}
    yield "lateral_slip", truck, {"compliance": 0.02}
    yield "castor_kick", truck, {"yaw": 0.01}
    for direction in QUARTERS:
        yield "floor_slope", truck, {"rate": 0.005, "direction": direction}


def _of_wheel(wheel: str, above: float, order: float | None) -> Iterator[tuple[str, str, dict[str, Any]]]:
    yield "wheel_diameter", wheel, {"ratio": 1.003}
    yield "radius_vs_speed", wheel, {"slope": 0.02}
    yield "count_loss", wheel, {"fraction": 0.01, "above": above}
    yield "traction_slip", wheel, {"compliance": 0.05}
    yield "latency", wheel, {"delay": 0.02}
    yield "gear_backlash", wheel, {"width": 1e-3}
    for phase in QUARTERS:
        yield "wheel_eccentricity", wheel, {"amplitude": 3e-4, "phase": phase}
        if order is not None:
            yield "gear_harmonic", wheel, {"amplitude": 2e-4, "order": order, "phase": phase}


def _of_linkage() -> Iterator[tuple[str, str, dict[str, Any]]]:
    for joint in ("joint_a", "joint_b"):
        yield "joint_bias", joint, {"bias": 0.005}
        yield "joint_backlash", joint, {"width": 0.01}
        for phase in QUARTERS:
            yield "joint_eccentricity", joint, {"amplitude": 0.005, "phase": phase}
    yield "link_bias", "link", {"bias": 0.005}
    yield "link_scale", "link", {"ratio": 1.05}
    for phase in QUARTERS:
        yield "link_eccentricity", "link", {"amplitude": 0.003, "phase": phase}
    for channel in ("joint_a", "joint_b", "link"):
        yield "latency", channel, {"delay": 0.02}
        yield "clock_drift", channel, {"rate": 5e-4}


def _usual_speed(drives: Sequence[Drive], wheel: int) -> float:
    return float(
        np.median(np.concatenate([np.abs(rates(each.way[:, wheel], each.time)[0]) for each in drives]))
    )


def _moments(effect: str, more: Mapping[str, Any], end: float) -> tuple[float | None, list[list[float]]]:
    """Return the moment from which an effect acts, and the intervals in which it does [s]."""
    if effect == "radius_step":
        return more["time"], [[more["time"], end]]
    if effect == "slip_patch":
        return more["intervals"][0][0], more["intervals"]
    if effect == "bump":
        return more["times"][0], [[time, time + CROSSING] for time in more["times"]]
    return None, []
