"""Faults of a MuJoCo robot's shape: other wheels, other axles, cables on its way."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from proof.mujoco_labels import crossings, label
from proof.mujoco_robot import WHEELS, Cable
from proof.mujoco_setting import Fault, with_truck, with_tyre

if TYPE_CHECKING:
    from proof.mujoco_drive import Drive
    from proof.mujoco_robot import Robot
    from proof.mujoco_setting import Setting


def healthy(at: Setting) -> Fault:
    """Return the robot as it is."""
    return Fault(at.robot, lambda _: [], kind="null")


def wheel_diameter(at: Setting) -> Fault:
    """A wheel of another size."""
    wheel, ratio = at.wheel(), 1 + at.sign() * at.rng.uniform(0.002, 0.008)
    likes = (("count_loss", wheel), ("radius_vs_speed", wheel))  # at one speed they are the same
    robot = with_tyre(at.robot, wheel, radius=at.robot.tyres[wheel].radius * ratio)
    return Fault(robot, lambda _: [label("wheel_diameter", wheel, {"ratio": ratio}, likes)])


def hardly(at: Setting) -> Fault:
    """A wheel larger by a few parts in a hundred thousand: nobody can tell."""
    wheel, ratio = at.wheel(), 1 + at.sign() * 3e-5
    robot = with_tyre(at.robot, wheel, radius=at.robot.tyres[wheel].radius * ratio)
    return Fault(robot, lambda _: [label("wheel_diameter", wheel, {"ratio": ratio})], kind="insufficient")


def wheel_eccentricity(at: Setting) -> Fault:
    """A wheel whose axle is off its centre."""
    wheel, amplitude, phase = at.wheel(), at.rng.uniform(3e-4, 1e-3), at.rng.uniform(-np.pi, np.pi)
    robot = with_tyre(at.robot, wheel, eccentricity=amplitude, phase=phase)
    seen = amplitude * nodding(at.robot, wheel) * np.exp(1j * (phase - at.zero_angle(wheel)))
    values = {"amplitude": float(np.abs(seen)), "phase": float(np.angle(seen))}
    return Fault(robot, lambda _: [label("wheel_eccentricity", wheel, values, (("gear_harmonic", wheel),))])


def nodding(robot: Robot, wheel: str) -> complex:
    """Return what an eccentric wheel's wave becomes, as a factor, because its truck nods.

    The wheel lifts its end of the axle, the truck turns about its castor, and the wheels turn with it.
    """
    return 1 + 0.5j * robot.tyres[wheel].radius / robot.trucks[wheel[0]].castor


def wheelbase(at: Setting) -> Fault:
    """Wheels mounted wider, or closer."""
    truck, ratio = at.truck(), 1 + at.sign() * at.rng.uniform(0.008, 0.03)
    robot = with_truck(at.robot, truck, track=at.robot.trucks[truck].track * ratio)
    return Fault(robot, lambda _: [label("wheelbase", truck, {"ratio": ratio}, (("turn_scrub", truck),))])


def wheel_misalignment(at: Setting) -> Fault:
    """An axle turned in its truck."""
    truck, angle = at.truck(), at.sign() * at.rng.uniform(0.005, 0.015)
    robot = with_truck(at.robot, truck, toe=angle)
    other = ("joint_bias", f"joint_{truck}")
    return Fault(robot, lambda _: [label("wheel_misalignment", truck, {"angle": angle}, (other,))])


def bump(at: Setting) -> Fault:
    """Cables across the way of one wheel, met at every lap."""
    wheel, height = at.wheel(), at.rng.uniform(0.005, 0.009)
    robot = replace(
        at.robot, cables=tuple(Cable(wheel, *place, height, 0.3) for place in _places(at, wheel, 4))
    )

    def tell(drive: Drive) -> list[dict[str, Any]]:
        spans, lost = crossings(drive, at.nominal, wheel, at.start)
        values = {"times": [first for first, _ in spans], "lost": lost}
        return [label("bump", wheel, values, (("slip_patch", wheel),), spans)]

    return Fault(robot, tell)


def _places(at: Setting, wheel: str, count: int) -> list[tuple[float, float, float]]:
    """Return places on a wheel's track where it rolls well ahead, and directions across the track there."""
    truck, side = WHEELS.index(wheel) // 2, 1 if wheel.endswith("left") else -1
    pose = at.healthy.poses[:, truck]
    half = side * at.nominal.tracks[truck] / 2
    x, y = pose[:, 0] - half * np.sin(pose[:, 2]), pose[:, 1] + half * np.cos(pose[:, 2])
    speed = np.diff(at.healthy.wheels[:, WHEELS.index(wheel)]) * at.nominal.radii[0] / at.healthy.time[1]
    yaw = np.diff(np.unwrap(pose[:, 2])) / at.healthy.time[1]
    rolling = (speed > 0.15) & (np.abs(yaw) < 0.35)
    steady = np.flatnonzero(np.convolve(~rolling, np.ones(121), "same") < 0.5)  # and 0.9 s before and after
    steady = steady if len(steady) > 500 else np.flatnonzero(rolling)
    rows = steady[
        np.linspace(0, len(steady) - 1, count + 2).astype(int)[1:-1] + at.rng.integers(-20, 20, count)
    ]
    return [(float(x[row]), float(y[row]), float(pose[row, 2] + np.pi / 2)) for row in rows]


def two_sizes(at: Setting) -> Fault:
    """A wheel of another size, and wheels mounted wider on some truck."""
    first = wheel_diameter(at)
    second = wheelbase(replace(at, robot=first.robot))
    return Fault(second.robot, lambda run: [*first.tell(run), *second.tell(run)], kind="multi")


def round_and_cables(at: Setting) -> Fault:
    """A wheel out of round, and cables on the way of some wheel."""
    first = wheel_eccentricity(at)
    second = bump(replace(at, robot=first.robot))
    return Fault(second.robot, lambda run: [*first.tell(run), *second.tell(run)], kind="multi")
