"""The faults that the engine conceals: each written out for itself, from the contract's words alone."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable

SMALL = 1e-9
OFFSET, WITHIN = 0.37, 0.03  # of a slab: where the first joint is, and how far beyond one a wheel has met it
SWING = 0.1  # [s] over which castors feel where a truck goes: rough ground under a spin is no reversal


@dataclass(slots=True)
class Fault:
    """A fault and what it remembers.

    Attributes:
        effect: of the vocabulary, or "unknown".
        component: on which it acts.
        parameters: by name.
        memory: of what happened before.
    """

    effect: str
    component: str
    parameters: dict[str, Any]
    memory: dict[str, Any] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Any:  # noqa: ANN401  numbers or lists of them
        return self.parameters[name]


Ground = tuple[str, float, float]  # a wheel, and where on the floor it is [m]


def touches(fault: Fault, wheel: str) -> bool:
    """Say whether a fault of wheels acts on this one: by name, by truck, or by side."""
    truck, side = wheel.split(".")
    return fault.component in {wheel, truck, side}


def travelled(
    fault: Fault,
    rolled: float,
    angle: tuple[float, float],
    speed: tuple[float, float],
    now: float,
    span: float,
    ground: Ground = ("", 0.0, 0.0),
) -> float:
    """Return the way of a wheel over the ground [m] for a way that it rolled.

    Args:
        fault: that acts on the wheel.
        rolled: nominal way in this step [m].
        angle: of its counter before and after [rad].
        speed: of the wheel [m/s], and its rate of change [m/s^2].
        now: time at the end of the step [s].
        span: of the step [s].
        ground: where on the floor the wheel is [m].
    """
    if fault.effect in _PLAIN:
        return rolled * _PLAIN[fault.effect](fault, speed[0], now)
    if fault.effect == "wheel_eccentricity":
        middle = 0.5 * (angle[0] + angle[1]) + fault["phase"]
        return rolled + float(fault["amplitude"]) * math.cos(middle) * (angle[1] - angle[0])
    if fault.effect == "gear_harmonic":
        waves = [math.cos(fault["order"] * at + fault["phase"]) for at in angle]
        return rolled + float(fault["amplitude"]) * (waves[1] - waves[0])
    found = rolled
    if fault.effect == "traction_slip":
        found = rolled - fault["compliance"] * speed[1] * abs(speed[0]) * span
    elif fault.effect == "bump":
        found = rolled - math.copysign(_bumped(fault, abs(rolled), now), rolled)
    elif fault.effect == "gear_backlash":
        found = _played(fault, rolled, fault["width"])
    elif fault.effect == "unknown":
        found = rolled + _strange_way(fault, rolled, now, ground)
    return found


def _slipped(fault: Fault, _speed: float, now: float) -> float:
    inside = any(start < now <= end for start, end in fault["intervals"])
    return 1.0 - float(fault["fraction"]) if inside else 1.0


_PLAIN: dict[str, Callable[[Fault, float, float], float]] = {
    "wheel_diameter": lambda fault, _speed, _now: float(fault["ratio"]),
    "radius_vs_speed": lambda fault, speed, _now: 1.0 + float(fault["slope"]) * abs(speed),
    "radius_step": lambda fault, _speed, now: float(fault["ratio"]) if now > fault["time"] else 1.0,
    "slip_patch": _slipped,
}


def _bumped(fault: Fault, way: float, now: float) -> float:
    """Return the way lost in this step: a stiff wheel swings about an edge, up and down."""
    since = fault.memory.setdefault("since", [-1.0] * len(fault["times"]))
    total = 0.0
    for number, (time, lost) in enumerate(zip(fault["times"], fault["lost"], strict=True)):
        if now <= time:
            continue
        radius = fault["radius"]
        half = fault.memory.setdefault(f"q{number}", _half_angle(lost, radius))
        before = max(since[number], 0.0)
        after = min(before + way, 2.0 * half * radius)
        since[number] = after
        total += (after - before) - radius * (
            math.sin(after / radius - half) - math.sin(before / radius - half)
        )
    return total


def _half_angle(lost: float, radius: float) -> float:
    """Return q of 2 R (q - sin q) = lost by halving."""
    low, high = 0.0, 1.5
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if 2.0 * radius * (middle - math.sin(middle)) < lost else (low, middle)
    return low


def _played(fault: Fault, moved: float, width: float) -> float:
    """Return what follows a motion through a play."""
    gap: float | None = fault.memory.get("gap")
    if gap is None:
        if abs(moved) < SMALL:
            return moved
        gap = math.copysign(0.5 * width, moved)
    wanted: float = gap + moved
    kept: float = max(-0.5 * width, min(0.5 * width, wanted))
    fault.memory["gap"] = kept
    return float(wanted - kept)


def _strange_way(fault: Fault, rolled: float, now: float, ground: Ground) -> float:
    """Return way that is gained by physics without a word in the vocabulary."""
    kind, size = fault["kind"], fault["size"]
    if kind == "slabs":  # joints between the slabs of a floor, that run both ways
        return float(-size * _joints_met(fault, ground) * math.copysign(1.0, rolled or 1.0))
    if kind == "warming":  # a tyre that warms up and stays warm
        return float(rolled * size * (1.0 - math.exp(-(now - fault["start"]) / fault["pitch"])))
    if kind == "hum":  # a supply that hums in time, not in angle
        return float(size * abs(rolled) * math.sin(2.0 * math.pi * (now - fault["start"]) / fault["pitch"]))
    return 0.0


def _joints_met(fault: Fault, ground: Ground) -> int:
    """Return how many joints a wheel has met; one that rolls along a joint does not meet it ever again."""
    wheel, *place = ground
    met = 0
    for axis, at in enumerate(place):
        cell = at / fault["pitch"] + OFFSET
        known = fault.memory.setdefault(f"{wheel} {axis}", math.floor(cell))
        if not known - WITHIN < cell < known + 1.0 + WITHIN:
            met += abs(math.floor(cell) - known)
            fault.memory[f"{wheel} {axis}"] = math.floor(cell)
    return met


def moved(
    fault: Fault, twist: tuple[float, float, float], heading: float, base: float, now: float, span: float
) -> tuple[float, float, float]:
    """Return a truck's motion in its own frame (forward, left, yaw) with a fault in it."""
    forward, left, yaw = twist
    one = fault.effect
    if one == "wheelbase":
        yaw /= fault["ratio"]
    elif one == "turn_scrub":
        across = math.hypot(forward, 0.5 * base * yaw)
        yaw /= 1.0 + fault["slope"] * (abs(yaw) / across if across > SMALL else 0.0)
    elif one == "wheel_misalignment":
        forward, left = forward * math.cos(fault["angle"]), left + forward * math.sin(fault["angle"])
    elif one == "lateral_slip":
        left -= fault["compliance"] * forward * yaw / span
    elif one == "floor_slope":
        creep, angle = fault["rate"] * abs(forward), fault["direction"] - heading
        forward, left = forward + creep * math.cos(angle), left + creep * math.sin(angle)
    elif one == "castor_kick":
        mean = fault.memory.get("mean", 0.0)
        mean += (forward / span - mean) * min(1.0, span / SWING)
        fault.memory["mean"] = mean
        sign = math.copysign(1.0, mean) if abs(mean) > 0.005 else 0.0
        last = fault.memory.get("sign", 0.0)
        if sign and last and sign != last:
            yaw += fault["yaw"]
        fault.memory["sign"] = sign or last
    elif one == "unknown":
        forward, left, yaw = _strange_motion(fault, (forward, left, yaw), heading, now, span)
    return forward, left, yaw


def _strange_motion(
    fault: Fault, twist: tuple[float, float, float], heading: float, now: float, span: float
) -> tuple[float, float, float]:
    forward, left, yaw = twist
    kind, size = fault["kind"], fault["size"]
    if kind == "pushes" and any(time < now <= time + 0.3 for time in fault["times"]):
        left, yaw = left + size * span / 0.3, yaw + 2.0 * size * span / 0.3
    if kind == "magnet":  # pulls sideways in one direction of the floor, twice per turn
        left += size * abs(forward) * math.sin(2.0 * heading)
    if kind == "tiring":  # a wheelbase that grows with time
        yaw *= 1.0 - size * (now - fault["start"]) / fault["pitch"]
    return forward, left, yaw


def shown(fault: Fault, reading: float, rest: float, joint_a: float, other: float) -> float:
    """Return what a joint's or the link's encoder shows."""
    one = fault.effect
    if one == "joint_backlash":
        last = fault.memory.get("shown", reading)
        half = 0.5 * fault["width"]
        fault.memory["shown"] = max(reading - half, min(reading + half, last))
        return float(fault.memory["shown"])
    more = 0.0
    if one in {"joint_bias", "link_bias"}:
        more = fault["bias"]
    elif one == "joint_eccentricity":
        more = fault["amplitude"] * math.cos(reading + fault["phase"])
    elif one == "link_eccentricity":
        more = fault["amplitude"] * math.cos(joint_a + fault["phase"])
    elif one == "link_scale":
        more = (fault["ratio"] - 1.0) * (reading - rest)
    elif one == "unknown":
        more = {
            "crosstalk": fault["size"] * math.sin(3.0 * other),
            "sag": fault["size"] * joint_a * joint_a,
        }.get(fault["kind"], 0.0)
    return float(reading + more)
