"""The faults that the engine conceals, each written from the description of its effect alone."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from studies.mismatch.engines.unnamed import motion_changed, reading_gained, way_gained

if TYPE_CHECKING:
    from collections.abc import Callable

    from studies.mismatch.engines.fault import ConcealedFault, Ground

SMALL = 1e-9
CASTOR_TIME = 0.1  # [s] over which a castor averages the speed: a rough floor under a spin is no reversal


def touches(fault: ConcealedFault, wheel: str) -> bool:
    """Say whether a fault acts on a wheel, which its component names by wheel, truck or side."""
    truck, side = wheel.split(".")
    return fault.component in {wheel, truck, side}


def travelled(
    fault: ConcealedFault,
    rolled: float,
    angle: tuple[float, float],
    speed: tuple[float, float],
    now: float,
    span: float,
    ground: Ground = ("", 0.0, 0.0),
) -> float:
    """Return the distance of a wheel over the ground [m] for a distance that it rolled.

    Args:
        fault: Fault that acts on the wheel.
        rolled: Nominal distance in this step [m].
        angle: Angle of the wheel's counter before and after the step [rad].
        speed: Speed of the wheel [m/s] and its rate of change [m/s^2].
        now: Time at the end of the step [s].
        span: Duration of the step [s].
        ground: The wheel and its place on the floor [m].
    """
    if fault.effect in _SCALED:
        return rolled * _SCALED[fault.effect](fault, speed[0], now)
    if fault.effect == "wheel_eccentricity":
        middle = 0.5 * (angle[0] + angle[1]) + fault["phase"]
        return rolled + float(fault["amplitude"]) * math.cos(middle) * (angle[1] - angle[0])
    if fault.effect == "gear_harmonic":
        waves = [math.cos(fault["order"] * at + fault["phase"]) for at in angle]
        return rolled + float(fault["amplitude"]) * (waves[1] - waves[0])
    way = rolled
    if fault.effect == "traction_slip":
        way = rolled - fault["compliance"] * speed[1] * abs(speed[0]) * span
    elif fault.effect == "bump":
        way = rolled - math.copysign(_bumped(fault, abs(rolled), now), rolled)
    elif fault.effect == "gear_backlash":
        way = _through_play(fault, rolled, fault["width"])
    elif fault.effect == "unknown":
        way = rolled + way_gained(fault, rolled, now, ground)
    return way


def _slipped(fault: ConcealedFault, _speed: float, now: float) -> float:
    inside = any(start < now <= end for start, end in fault["intervals"])
    return 1.0 - float(fault["fraction"]) if inside else 1.0


_SCALED: dict[str, Callable[[ConcealedFault, float, float], float]] = {
    "wheel_diameter": lambda fault, _speed, _now: float(fault["ratio"]),
    "radius_vs_speed": lambda fault, speed, _now: 1.0 + float(fault["slope"]) * abs(speed),
    "radius_step": lambda fault, _speed, now: float(fault["ratio"]) if now > fault["time"] else 1.0,
    "slip_patch": _slipped,
}


def _bumped(fault: ConcealedFault, way: float, now: float) -> float:
    """Return the distance lost in this step [m]: a stiff wheel turns about an edge, up and down."""
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
    """Return the angle q [rad] of 2 R (q - sin q) = lost, by bisection."""
    low, high = 0.0, 1.5
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if 2.0 * radius * (middle - math.sin(middle)) < lost else (low, middle)
    return low


def _through_play(fault: ConcealedFault, moved: float, width: float) -> float:
    """Return the motion [m] that comes through a gear with play."""
    gap: float | None = fault.memory.get("gap")
    if gap is None:
        if abs(moved) < SMALL:
            return moved
        gap = math.copysign(0.5 * width, moved)
    wanted: float = gap + moved
    kept: float = max(-0.5 * width, min(0.5 * width, wanted))
    fault.memory["gap"] = kept
    return float(wanted - kept)


def moved(
    fault: ConcealedFault,
    twist: tuple[float, float, float],
    heading: float,
    base: float,
    now: float,
    span: float,
    place: tuple[float, float] = (0.0, 0.0),
) -> tuple[float, float, float]:
    """Return a truck's motion in a step with a fault in it.

    Args:
        fault: Fault that acts on the truck.
        twist: Motion in the truck's frame without it: forward [m], left [m], yaw [rad].
        heading: Heading of the truck [rad].
        base: Wheelbase of the truck [m].
        now: Time at the end of the step [s].
        span: Duration of the step [s].
        place: Place of the truck on the floor [m].
    """
    forward, left, yaw = twist
    effect = fault.effect
    if effect == "wheelbase":
        yaw /= fault["ratio"]
    elif effect == "turn_scrub":
        across = math.hypot(forward, 0.5 * base * yaw)
        yaw /= 1.0 + fault["slope"] * (abs(yaw) / across if across > SMALL else 0.0)
    elif effect == "wheel_misalignment":
        forward, left = forward * math.cos(fault["angle"]), left + forward * math.sin(fault["angle"])
    elif effect == "lateral_slip":
        left -= fault["compliance"] * forward * yaw / span
    elif effect == "floor_slope":
        creep, angle = fault["rate"] * abs(forward), fault["direction"] - heading
        forward, left = forward + creep * math.cos(angle), left + creep * math.sin(angle)
    elif effect == "castor_kick":
        mean = fault.memory.get("mean", 0.0)
        mean += (forward / span - mean) * min(1.0, span / CASTOR_TIME)
        fault.memory["mean"] = mean
        sign = math.copysign(1.0, mean) if abs(mean) > 0.005 else 0.0
        last = fault.memory.get("sign", 0.0)
        if sign and last and sign != last:
            yaw += fault["yaw"]
        fault.memory["sign"] = sign or last
    elif effect == "unknown":
        forward, left, yaw = motion_changed(fault, twist, base, (place, heading), (now, span))
    return forward, left, yaw


def shown(fault: ConcealedFault, reading: float, rest: float, joint_a: float, other: float) -> float:
    """Return the reading of a joint's or the link's encoder with a fault in it [rad, m].

    Args:
        fault: Fault that acts on the encoder.
        reading: True angle of the joint [rad], or length of the link [m].
        rest: Length of the link at rest [m].
        joint_a: True angle of joint a [rad].
        other: True angle of the other joint [rad].
    """
    effect = fault.effect
    if effect == "joint_backlash":
        last = fault.memory.get("shown", reading)
        half = 0.5 * fault["width"]
        fault.memory["shown"] = max(reading - half, min(reading + half, last))
        return float(fault.memory["shown"])
    more = 0.0
    if effect in {"joint_bias", "link_bias"}:
        more = fault["bias"]
    elif effect == "joint_eccentricity":
        more = fault["amplitude"] * math.cos(reading + fault["phase"])
    elif effect == "link_eccentricity":
        more = fault["amplitude"] * math.cos(joint_a + fault["phase"])
    elif effect == "link_scale":
        more = (fault["ratio"] - 1.0) * (reading - rest)
    elif effect == "unknown":
        more = reading_gained(fault, joint_a, other)
    return float(reading + more)
