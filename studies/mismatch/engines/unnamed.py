"""Physics without a name in the vocabulary, as faults that an engine conceals.

The first kinds depend on one quantity each. Those that are called farther are no curve in any one quantity:
a product of two, a memory of the drive, a resonance.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from studies.mismatch.engines.fault import ConcealedFault, Ground

    Twist = tuple[float, float, float]

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


def way_gained(fault: ConcealedFault, rolled: float, now: float, ground: Ground) -> float:
    """Return the distance that a wheel gains [m] on a distance that it rolled.

    Args:
        fault: Fault that acts on the wheel.
        rolled: Nominal distance in this step [m].
        now: Time at the end of the step [s].
        ground: The wheel and its place on the floor [m].
    """
    kind, size = fault["kind"], fault["size"]
    if kind == "slabs":  # joints between slabs of the floor, along both axes
        return float(-size * _joints_met(fault, ground) * math.copysign(1.0, rolled or 1.0))
    if kind == "warming":  # a tyre that warms up and stays warm
        return float(rolled * size * (1.0 - math.exp(-(now - fault["start"]) / fault["pitch"])))
    if kind == "hum":  # a supply that hums in time, not in angle
        return float(size * abs(rolled) * math.sin(2.0 * math.pi * (now - fault["start"]) / fault["pitch"]))
    if kind == "warmth":  # a tyre that is warm from what it rolled of late, and cools
        return rolled * float(size) * _warmth(fault, abs(rolled), now)
    return 0.0


def _joints_met(fault: ConcealedFault, ground: Ground) -> int:
    """Return how many joints a wheel crosses now; while it rolls along a joint it does not cross it again."""
    wheel, *place = ground
    met = 0
    for axis, at in enumerate(place):
        cell = at / fault["pitch"] + FIRST_JOINT
        known = fault.memory.setdefault(f"{wheel} {axis}", math.floor(cell))
        if not known - BEYOND < cell < known + 1.0 + BEYOND:
            met += abs(math.floor(cell) - known)
            fault.memory[f"{wheel} {axis}"] = math.floor(cell)
    return met


def _warmth(fault: ConcealedFault, way: float, now: float) -> float:
    """Return how warm a tyre is: a mean of its speed over the time that it takes to cool."""
    warmth, last = fault.memory.get("warmth", 0.0), fault.memory.get("now", now)
    fault.memory["now"] = now
    fault.memory["warmth"] = warmth + (way / WARMING_SPEED - warmth * (now - last)) / fault["pitch"]
    return float(fault.memory["warmth"])


def motion_changed(
    fault: ConcealedFault,
    twist: Twist,
    base: float,
    at: tuple[tuple[float, float], float],
    when: tuple[float, float],
) -> Twist:
    """Return a truck's motion in a step: forward [m], left [m], yaw [rad].

    Args:
        fault: Fault that acts on the truck.
        twist: Motion without it.
        base: Wheelbase of the truck [m].
        at: Place of the truck on the floor [m], and its heading [rad].
        when: Time at the end of the step, and its duration [s].
    """
    forward, left, yaw = twist
    kind, size, (place, heading), (now, span) = fault["kind"], float(fault["size"]), at, when
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


def reading_gained(fault: ConcealedFault, joint_a: float, other: float) -> float:
    """Return what an encoder of the linkage shows too much [rad, m].

    Args:
        fault: Fault that acts on the encoder.
        joint_a: True angle of joint a [rad].
        other: True angle of the other joint [rad].
    """
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
