"""The laws, backwards: what a robot with an effect would have counted and stamped on the motion driven.

Each law is written from the vocabulary's description of its effect alone. The truth of a recording is its
motion: `way` of a healthy wheel is the way that it travelled. A wheel with an effect has to roll another way
to travel the same, and its counter shows that one. Laws of speed are solved by fixed point iteration, because
the vocabulary means the speed of the wheel as it rolls.

Effects that move a truck as no wheel does cannot be put into counts. They become motion that dead reckoning
lacks, for who asks how strong they would show.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from studies.mismatch.engines.strength import Drive, Poses, rates
from studies.mismatch.engines.vocabulary import LINKAGE, TRUCKS, WHEELS, Array

Parameters = Mapping[str, Any]
Value = Any  # a number, or an array of one for each sample

ITERATIONS = 6  # of a fixed point; each gains the effect's size, some percent at most
REVERSED = 1.5  # counts that a wheel rolls back until it has reversed; what jitters by a count has not
SCALED = ("wheel_diameter", "radius_vs_speed", "radius_step", "slip_patch")  # scale the distance of a wheel
STANDS = 0.005  # [m/s] below which a truck stands


def altered(drive: Drive, effect: str, component: str, parameters: Parameters) -> Drive:
    """Return a drive as the recording of a robot with an effect shows it, on the same true motion."""
    if component == "poses":
        aged = {
            truck: Poses(_stamps(drive, poses, effect, parameters), poses.pose)
            for truck, poses in drive.poses.items()
        }
        return replace(drive, poses=aged)
    if component in LINKAGE:
        channel = LINKAGE.index(component)
        reading, joint_a = drive.reading[:, channel], drive.reading[:, 0]
        if effect in {"latency", "clock_drift"}:
            shown = of_age(reading, drive.time, parameters)
        elif effect == "joint_backlash":
            shown = _through_backlash(reading, parameters["width"])
        else:
            shown = reading_of(effect, parameters, reading, joint_a, drive.rest)
        return drive.with_reading(channel, shown)
    if effect in OF_TRUCKS:
        return _wider(drive, effect, TRUCKS.index(component), parameters)
    if effect in OF_BODIES:
        truck = TRUCKS.index(component)
        kicks = effect == "castor_kick"
        more = _castor_kick(drive, truck, parameters) if kicks else _moved(drive, effect, truck, parameters)
        return drive.with_more(truck, -more)
    for wheel in wheels_of(component):
        drive = drive.with_way(wheel, OF_WHEELS[effect](drive, wheel, parameters))
    return drive


def wheels_of(component: str) -> tuple[int, ...]:
    """Return the columns of a wheel, or of both wheels of a truck."""
    if component in WHEELS:
        return (WHEELS.index(component),)
    return 2 * TRUCKS.index(component), 2 * TRUCKS.index(component) + 1


def _from_steps(first: float, steps: Array) -> Array:
    """Return a way `(N,)` from where it begins, and its steps `(N - 1,)`."""
    return np.concatenate(([first], first + np.cumsum(steps)))


def _rolled(drive: Drive, wheel: int, law: Callable[[Array, Array], Array]) -> Array:
    """Return the way `(N,)` whose steps are what `law(rolled way, travelled steps)` gives of itself."""
    travelled = drive.way[:, wheel]
    steps, way = np.diff(travelled), travelled
    for _ in range(ITERATIONS):
        way = _from_steps(travelled[0], law(way, steps))
    return way


def rolling_ratio(effect: str, parameters: Parameters, speed: Value, time: Value) -> Value:
    """Return how far a wheel travels over how far it rolls, with an effect of `SCALED`, of one or all steps.

    `speed` is that of the wheel [m/s], `time` the end of the step [s].
    """
    if effect == "wheel_diameter":
        return parameters["ratio"]
    if effect == "radius_vs_speed":
        return 1.0 + parameters["slope"] * abs(speed)
    if effect == "radius_step":
        return np.where(time > parameters["time"], parameters["ratio"], 1.0)
    within = [(time > start) & (time <= end) for start, end in parameters["intervals"]]
    return np.where(np.any(within, axis=0), 1.0 - parameters["fraction"], 1.0)


def counted_share(parameters: Parameters, speed: Value) -> Value:
    """Return the share of its counts that an encoder with `count_loss` counts at speeds [m/s]."""
    return np.where(abs(speed) > parameters["above"], 1.0 - parameters["fraction"], 1.0)


def _scaled(effect: str, drive: Drive, wheel: int, parameters: Parameters) -> Array:
    def law(way: Array, steps: Array) -> Array:
        speed, _ = rates(way, drive.time)
        return np.asarray(steps / rolling_ratio(effect, parameters, speed, drive.time[1:]))

    return _rolled(drive, wheel, law)


def _traction_slip(drive: Drive, wheel: int, parameters: Parameters) -> Array:
    period = np.diff(drive.time)

    def law(way: Array, steps: Array) -> Array:
        speed, acceleration = rates(way, drive.time)
        return np.asarray(steps + parameters["compliance"] * acceleration * np.abs(speed) * period)

    return _rolled(drive, wheel, law)


def _with_wave(drive: Drive, wheel: int, amplitude: float, order: float, phase: float) -> Array:
    """Return the rolled way of a wheel that travels amplitude cos(order angle + phase) beyond it."""
    travelled, radius = drive.way[:, wheel], drive.radius[wheel]
    way = travelled
    for _ in range(ITERATIONS):
        wave = amplitude * np.cos(order * way / radius + phase)
        way = travelled - (wave - wave[0])
    return way


def _bump(drive: Drive, wheel: int, parameters: Parameters) -> Array:
    travelled, radius = np.diff(drive.way[:, wheel]), float(drive.radius[wheel])
    more = np.zeros(len(travelled))
    for time, lost in zip(parameters["times"], parameters["lost"], strict=True):
        half = half_angle(lost, radius)
        since = np.cumsum(np.where(drive.time[1:] > time, np.abs(travelled), 0.0))
        at = np.minimum(np.concatenate(([0.0], since)), 2.0 * radius * math.sin(half))
        # on the edge a stiff wheel turns about it: travelled R (sin(rolled / R - q) + sin q)
        rolled = radius * (np.arcsin(at / radius - math.sin(half)) + half)
        more += np.diff(rolled - at)
    return _from_steps(drive.way[0, wheel], travelled + np.sign(travelled) * more)


def half_angle(lost: float, radius: float) -> float:
    """Return the angle q [rad] of 2 R (q - sin q) = lost, by Newton's method."""
    angle = math.cbrt(3.0 * lost / radius)
    for _ in range(20 if lost else 0):
        angle -= (2.0 * radius * (angle - math.sin(angle)) - lost) / (2.0 * radius * (1.0 - math.cos(angle)))
    return angle


def _count_loss(drive: Drive, wheel: int, parameters: Parameters) -> Array:
    speed, _ = rates(drive.way[:, wheel], drive.time)
    return _from_steps(drive.way[0, wheel], counted_share(parameters, speed) * np.diff(drive.way[:, wheel]))


def of_age(value: Value, time: Array, parameters: Parameters) -> Array:
    """Return a channel `(N,)` whose samples are old by a delay, or by a rate times the time."""
    age = parameters["delay"] if "delay" in parameters else parameters["rate"] * (time - time[0])
    return np.asarray(np.interp(time - age, time, value))


def _gear_backlash(drive: Drive, wheel: int, parameters: Parameters) -> Array:
    way, reversed_by = drive.way[:, wheel], REVERSED * drive.count[wheel]
    lead = np.zeros(len(way))  # of the motor, in half widths: +1 where it drives the wheel forward
    direction, farthest = 0.0, 0
    for sample in range(1, len(way)):
        gone = way[sample] - way[farthest]
        lead[sample] = direction
        if direction * gone > 0.0:
            farthest = sample
        elif abs(gone) > reversed_by:
            new = math.copysign(1.0, gone)
            begin = farthest if direction else 0
            lead[begin : sample + 1] = np.linspace(direction or new, new, sample + 1 - begin)
            direction, farthest = new, sample
    return np.asarray(way + 0.5 * parameters["width"] * (lead - lead[0]))


def _wider(drive: Drive, effect: str, truck: int, parameters: Parameters) -> Drive:
    """Return a drive whose wheels turn a truck over a wider wheelbase: by a ratio, or the wider in a bend."""
    base, wheels = drive.wheelbase[truck], (2 * truck, 2 * truck + 1)
    left, right = np.diff(drive.way[:, wheels], axis=0).T
    travelled = (right - left) / base
    yaw = travelled
    for _ in range(ITERATIONS):
        if effect == "wheelbase":
            yaw = travelled * float(parameters["ratio"])
        else:
            across = np.hypot(drive.twist(truck)[:, 0], 0.5 * base * yaw)
            curvature = np.divide(np.abs(yaw), across, out=np.zeros_like(yaw), where=across > 0.0)
            yaw = travelled * (1.0 + parameters["slope"] * curvature)
    middle, half = 0.5 * (left + right), 0.5 * base * yaw
    for wheel, steps in zip(wheels, (middle - half, middle + half), strict=True):
        drive = drive.with_way(wheel, _from_steps(drive.way[0, wheel], steps))
    return drive


def reading_of(effect: str, parameters: Parameters, reading: Value, joint_a: Value, rest: float) -> Value:
    """Return what an encoder of the linkage reads with an effect that has no memory, of one or all samples.

    `reading` and `joint_a` are true [rad, m]; `rest` is the link's length at rest [m].
    """
    if effect in {"joint_bias", "link_bias"}:
        return reading + parameters["bias"]
    if effect == "link_scale":
        return reading + (parameters["ratio"] - 1.0) * (reading - rest)
    angle = joint_a if effect == "link_eccentricity" else reading
    return reading + parameters["amplitude"] * np.cos(angle + parameters["phase"])


def body_motion(
    effect: str, parameters: Parameters, step: tuple[Value, Value], span: Value, heading: Value
) -> tuple[Value, Value]:
    """Return the motion forward and left [m] that an effect adds to a truck's, of one or all steps.

    A step is the motion forward [m] and the yaw [rad] within a span [s]; the heading is on the floor [rad].
    """
    forward, yaw = step
    if effect == "wheel_misalignment":
        angle = parameters["angle"]
        return forward * (math.cos(angle) - 1.0), forward * math.sin(angle)
    if effect == "lateral_slip":
        return 0.0 * forward, -parameters["compliance"] * forward * yaw / span
    creep, angle = parameters["rate"] * abs(forward), parameters["direction"] - heading
    return creep * np.cos(angle), creep * np.sin(angle)


def _through_backlash(reading: Array, width: float) -> Array:
    shown, half = reading.copy(), 0.5 * width
    for sample in range(1, len(shown)):
        shown[sample] = max(reading[sample] - half, min(reading[sample] + half, shown[sample - 1]))
    return shown


def _moved(drive: Drive, effect: str, truck: int, parameters: Parameters) -> Array:
    """Return the motion of a truck `(N - 1, 3)` that an effect without memory adds."""
    forward, _, yaw = drive.twist(truck).T
    heading = drive.path(truck)[:-1, 2] + _heading_at_start(drive, truck)
    added = body_motion(effect, parameters, (forward, yaw), np.diff(drive.time), heading)
    return np.stack([*added, 0.0 * forward], axis=1)


def _heading_at_start(drive: Drive, truck: int) -> float:
    poses = drive.poses.get(truck)
    return 0.0 if poses is None or not len(poses.pose) else float(poses.pose[0, 2])


def _castor_kick(drive: Drive, truck: int, parameters: Parameters) -> Array:
    way = 0.5 * (drive.way[:, 2 * truck] + drive.way[:, 2 * truck + 1])
    speed, _ = rates(way, drive.time)
    runs = np.flatnonzero(np.abs(speed) > STANDS)
    kicks = np.zeros((len(speed), 3))
    kicks[runs[1:][np.diff(np.sign(speed[runs])) != 0.0], 2] = parameters["yaw"]
    return kicks


def _stamps(drive: Drive, poses: Poses, effect: str, parameters: Parameters) -> Array:
    if effect == "latency":
        return np.asarray(poses.time + parameters["delay"])
    start = drive.time[0]
    return np.asarray(start + (poses.time - start) / (1.0 - parameters["rate"]))


OF_WHEELS: dict[str, Callable[[Drive, int, Parameters], Array]] = {
    **{effect: partial(_scaled, effect) for effect in SCALED},
    "wheel_eccentricity": lambda drive, wheel, more: _with_wave(
        drive, wheel, more["amplitude"], 1.0, more["phase"] - 0.5 * math.pi
    ),
    "bump": _bump,
    "count_loss": _count_loss,
    **dict.fromkeys(
        ("latency", "clock_drift"), lambda drive, wheel, more: of_age(drive.way[:, wheel], drive.time, more)
    ),
    "gear_backlash": _gear_backlash,
    "gear_harmonic": lambda drive, wheel, more: _with_wave(
        drive, wheel, more["amplitude"], more["order"], more["phase"]
    ),
    "traction_slip": _traction_slip,
}
OF_TRUCKS = {"wheelbase", "turn_scrub"}
OF_BODIES = {"wheel_misalignment", "lateral_slip", "floor_slope", "castor_kick"}
