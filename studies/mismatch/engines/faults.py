"""The faults that the engine conceals, step by step; laws without memory are those of `laws`.

Faults called "unknown" are physics without a name in the vocabulary. Its first kinds depend on one quantity
each. Those of `FARTHER` are no curve in any one quantity: a product of two, a memory of the drive, a
resonance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from studies.mismatch.engines.laws import SCALED, body_motion, half_angle, reading_of, rolling_ratio

Twist = tuple[float, float, float]  # forward [m], left [m] and yaw [rad] in the truck's frame

Place = tuple[float, float]  # on the floor [m]


class WheelStep(NamedTuple):
    """What a wheel does in a step."""

    rolled: float  # nominal distance [m]
    angle: tuple[float, float]  # of its counter, before and after [rad]
    speed: float  # [m/s]
    acceleration: float  # [m/s^2]
    now: float  # time at the end [s]
    span: float  # duration [s]
    wheel: str
    place: Place


class TruckStep(NamedTuple):
    """Where a truck is in a step."""

    wheelbase: float  # [m]
    place: Place
    heading: float  # [rad]
    now: float  # time at the end [s]
    span: float  # duration [s]


@dataclass(slots=True)
class ConcealedFault:
    """A fault in a robot, with its state."""

    effect: str  # name of the effect in the vocabulary, or "unknown"
    component: str  # component on which it acts
    parameters: dict[str, Any]  # parameters of the effect, by name
    # state that the fault keeps from step to step; empty at the start of a drive
    memory: dict[str, Any] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Any:  # noqa: ANN401  numbers or lists of them
        return self.parameters[name]


# Shares of a slab: place of the first joint, and from where a wheel has crossed it.
FIRST_JOINT, BEYOND = 0.37, 0.03
WARMING_SPEED = 0.3  # [m/s] at which a tyre reaches its whole warmth
WOUND = 0.3  # [rad] of turn that winds a tyre up
DAMPING = 0.08  # of a link that swings, over the critical one

# Usual size of each kind, and its other number: a length [m], a time [s], or none.
KINDS: dict[str, tuple[float, float]] = {
    "slabs": (6e-4, 0.7), "warming": (0.006, 40.0), "hum": (0.05, 3.7), "pushes": (0.02, 0.0),
    "magnet": (0.02, 0.0), "tiring": (0.05, 0.0), "crosstalk": (0.01, 0.0), "sag": (0.012, 0.0),
    "warmth": (0.01, 20.0), "load transfer": (0.05, 0.0), "field": (0.02, 1.7), "wind-up": (0.02, 0.0),
    "swing": (0.015, 0.9),
}  # fmt: skip
FARTHER = ("warmth", "load transfer", "field", "wind-up", "swing")


def _way_gained(fault: ConcealedFault, step: WheelStep) -> float:
    """Return the distance that a wheel gains by physics without a name [m]."""
    kind, size, since = fault["kind"], float(fault["size"]), step.now - fault["start"]
    if kind == "slabs":  # joints between slabs of the floor, along both axes
        return -size * _joints_met(fault, step) * math.copysign(1.0, step.rolled or 1.0)
    if kind == "warming":  # a tyre that warms up and stays warm
        return step.rolled * size * (1.0 - math.exp(-since / fault["pitch"]))
    if kind == "hum":  # a supply that hums in time, not in angle
        return size * abs(step.rolled) * math.sin(2.0 * math.pi * since / fault["pitch"])
    if kind == "warmth":  # a tyre that is warm from what it rolled of late, and cools
        return step.rolled * size * _warmth(fault, abs(step.rolled), step.now)
    return 0.0


def _joints_met(fault: ConcealedFault, step: WheelStep) -> int:
    """Return how many joints a wheel crosses now; while it rolls along a joint it does not cross it again."""
    met = 0
    for axis, at in enumerate(step.place):
        cell = at / fault["pitch"] + FIRST_JOINT
        known = fault.memory.setdefault(f"{step.wheel} {axis}", math.floor(cell))
        if not known - BEYOND < cell < known + 1.0 + BEYOND:
            met += abs(math.floor(cell) - known)
            fault.memory[f"{step.wheel} {axis}"] = math.floor(cell)
    return met


def _warmth(fault: ConcealedFault, way: float, now: float) -> float:
    """Return how warm a tyre is: a mean of its speed over the time that it takes to cool."""
    warmth, last = fault.memory.get("warmth", 0.0), fault.memory.get("now", now)
    fault.memory["now"] = now
    fault.memory["warmth"] = warmth + (way / WARMING_SPEED - warmth * (now - last)) / fault["pitch"]
    return float(fault.memory["warmth"])


def _motion_changed(fault: ConcealedFault, twist: Twist, step: TruckStep) -> Twist:
    """Return a truck's motion in a step with physics without a name in it."""
    forward, left, yaw = twist
    kind, size, (base, place, heading, now, span) = fault["kind"], float(fault["size"]), step
    if kind == "pushes" and any(time < now <= time + 0.3 for time in fault["times"]):
        left, yaw = left + size * span / 0.3, yaw + 2.0 * size * span / 0.3
    elif kind == "magnet":  # pulls sideways in one direction of the floor, twice per turn
        left += size * abs(forward) * math.sin(2.0 * heading)
    elif kind == "tiring":  # a wheelbase that grows with time
        yaw *= 1.0 - size * (now - fault["start"]) / fault["pitch"]
    elif kind == "load transfer":  # in a bend the outer tyre is pressed flat, the inner one rises
        pressed = size * forward * yaw / span**2
        forward, yaw = forward - 0.5 * base * yaw * pressed, yaw - 2.0 * forward / base * pressed
    elif kind == "field":  # pulls sideways by heading and by place
        left += size * abs(forward) * math.sin(heading) * math.cos(2.0 * math.pi * place[0] / fault["pitch"])
    elif kind == "wind-up":  # tyres that are wound up by a turn, and unwind by the next
        wound = fault.memory.get("wound", 0.0)
        more = (math.copysign(size, yaw) - wound) * min(1.0, abs(yaw) / WOUND)
        fault.memory["wound"] = wound + more
        yaw -= more
    return forward, left, yaw


def _reading_gained(fault: ConcealedFault, joint_a: float, other: float) -> float:
    """Return what an encoder of the linkage shows too much by physics without a name [rad, m]."""
    kind, size = fault["kind"], float(fault["size"])
    if kind == "crosstalk":
        return size * math.sin(3.0 * other)
    if kind == "sag":
        return size * joint_a * joint_a
    if kind == "swing":
        return size * float(fault.memory.get("swing", 0.0))
    return 0.0


def felt(fault: ConcealedFault, acceleration: float, span: float) -> None:
    """Let a fault feel the acceleration [m/s^2] of truck a for some time [s]: what swings goes on."""
    if fault.parameters.get("kind") != "swing":
        return
    turn = 2.0 * math.pi / fault["pitch"]
    swing, rate = fault.memory.get("swing", 0.0), fault.memory.get("rate", 0.0)
    rate += (turn**2 * (acceleration - swing) - 2.0 * DAMPING * turn * rate) * span
    fault.memory["swing"], fault.memory["rate"] = swing + rate * span, rate


SMALL = 1e-9
CASTOR_TIME = 0.1  # [s] over which a castor averages the speed: a rough floor under a spin is no reversal


def touches(fault: ConcealedFault, wheel: str) -> bool:
    """Say whether a fault acts on a wheel, which its component names by wheel, truck or side."""
    truck, side = wheel.split(".")
    return fault.component in {wheel, truck, side}


def travelled(fault: ConcealedFault, step: WheelStep) -> float:
    """Return the distance of a wheel over the ground [m] in a step, with a fault that acts on it."""
    rolled, angle = step.rolled, step.angle
    if fault.effect in SCALED:
        return rolled * float(rolling_ratio(fault.effect, fault.parameters, step.speed, step.now))
    if fault.effect == "wheel_eccentricity":
        middle = 0.5 * (angle[0] + angle[1]) + fault["phase"]
        return rolled + float(fault["amplitude"]) * math.cos(middle) * (angle[1] - angle[0])
    if fault.effect == "gear_harmonic":
        waves = [math.cos(fault["order"] * at + fault["phase"]) for at in angle]
        return rolled + float(fault["amplitude"]) * (waves[1] - waves[0])
    way = rolled
    if fault.effect == "traction_slip":
        way = rolled - fault["compliance"] * step.acceleration * abs(step.speed) * step.span
    elif fault.effect == "bump":
        way = rolled - math.copysign(_bumped(fault, abs(rolled), step.now), rolled)
    elif fault.effect == "gear_backlash":
        way = _through_play(fault, rolled, fault["width"])
    elif fault.effect == "unknown":
        way = rolled + _way_gained(fault, step)
    return way


def _bumped(fault: ConcealedFault, way: float, now: float) -> float:
    """Return the distance lost in this step [m]: a stiff wheel turns about an edge, up and down."""
    since = fault.memory.setdefault("since", [-1.0] * len(fault["times"]))
    total = 0.0
    for number, (time, lost) in enumerate(zip(fault["times"], fault["lost"], strict=True)):
        if now <= time:
            continue
        radius = fault["radius"]
        half = fault.memory.setdefault(f"q{number}", half_angle(lost, radius))
        before = max(since[number], 0.0)
        after = min(before + way, 2.0 * half * radius)
        since[number] = after
        total += (after - before) - radius * (
            math.sin(after / radius - half) - math.sin(before / radius - half)
        )
    return total


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


def moved(fault: ConcealedFault, twist: Twist, step: TruckStep) -> Twist:
    """Return a truck's motion in a step with a fault that acts on it, from the motion without it."""
    forward, left, yaw = twist
    base, span = step.wheelbase, step.span
    effect = fault.effect
    if effect == "wheelbase":
        yaw /= fault["ratio"]
    elif effect == "turn_scrub":
        across = math.hypot(forward, 0.5 * base * yaw)
        yaw /= 1.0 + fault["slope"] * (abs(yaw) / across if across > SMALL else 0.0)
    elif effect in {"wheel_misalignment", "lateral_slip", "floor_slope"}:
        ahead, aside = body_motion(effect, fault.parameters, (forward, yaw), span, step.heading)
        forward, left = forward + float(ahead), left + float(aside)
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
        forward, left, yaw = _motion_changed(fault, twist, step)
    return forward, left, yaw


def shown(fault: ConcealedFault, reading: float, rest: float, joint_a: float, other: float) -> float:
    """Return what a joint's or the link's encoder with a fault shows of a true reading [rad, m].

    `rest` is the link's length at rest [m], `joint_a` and `other` are true angles of joints [rad].
    """
    effect = fault.effect
    if effect == "joint_backlash":
        last = fault.memory.get("shown", reading)
        half = 0.5 * fault["width"]
        fault.memory["shown"] = max(reading - half, min(reading + half, last))
        return float(fault.memory["shown"])
    if effect in {"latency", "clock_drift"}:
        return reading  # the engine ages the counts
    if effect == "unknown":
        return reading + _reading_gained(fault, joint_a, other)
    return float(reading_of(effect, fault.parameters, reading, joint_a, rest))
