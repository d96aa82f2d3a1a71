"""Faults of a MuJoCo robot's geometry: other wheels, other axles, cables on its path."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from studies.mismatch.engines.mujoco.labels import label
from studies.mismatch.engines.mujoco.robot import WHEELS, Cable
from studies.mismatch.engines.mujoco.setting import FaultyRobot, with_truck, with_tyre
from studies.mismatch.engines.true_motion import crossings

if TYPE_CHECKING:
    from studies.mismatch.engines.mujoco.robot import Robot
    from studies.mismatch.engines.mujoco.setting import Setting
    from studies.mismatch.engines.true_motion import Drive


def healthy(at: Setting) -> FaultyRobot:
    """Return the robot without a fault."""
    return FaultyRobot(at.robot, lambda _: [], kind="null")


def wheel_diameter(at: Setting) -> FaultyRobot:
    """Return a robot with a wheel of another diameter."""
    wheel, ratio = at.wheel(), 1 + at.sign() * at.rng.uniform(0.002, 0.008)
    likes = (("count_loss", wheel), ("radius_vs_speed", wheel))  # at one speed they are the same
    robot = with_tyre(at.robot, wheel, radius=at.robot.tyres[wheel].radius * ratio)
    return FaultyRobot(robot, lambda _: [label("wheel_diameter", wheel, {"ratio": ratio}, likes)])


def hardly(at: Setting) -> FaultyRobot:
    """Return a robot with a wheel that differs by 3e-5, which no recording can show."""
    wheel, ratio = at.wheel(), 1 + at.sign() * 3e-5
    robot = with_tyre(at.robot, wheel, radius=at.robot.tyres[wheel].radius * ratio)
    return FaultyRobot(
        robot, lambda _: [label("wheel_diameter", wheel, {"ratio": ratio})], kind="insufficient"
    )


def wheel_eccentricity(at: Setting) -> FaultyRobot:
    """Return a robot with a wheel whose axle is off its centre."""
    wheel, amplitude, phase = at.wheel(), at.rng.uniform(3e-4, 1e-3), at.rng.uniform(-np.pi, np.pi)
    robot = with_tyre(at.robot, wheel, eccentricity=amplitude, phase=phase)
    seen = amplitude * nodding(at.robot, wheel) * np.exp(1j * (phase - at.zero_angle(wheel)))
    values = {"amplitude": float(np.abs(seen)), "phase": float(np.angle(seen))}
    return FaultyRobot(
        robot, lambda _: [label("wheel_eccentricity", wheel, values, (("gear_harmonic", wheel),))]
    )


def nodding(robot: Robot, wheel: str) -> complex:
    """Return the complex factor on an eccentric wheel's wave that comes from the pitching of its truck.

    The wheel lifts its end of the axle, the truck pitches about its castor, and the wheels turn with it.
    """
    return 1 + 0.5j * robot.tyres[wheel].radius / robot.trucks[wheel[0]].castor


def wheelbase(at: Setting) -> FaultyRobot:
    """Return a robot with another track on one truck."""
    truck, ratio = at.truck(), 1 + at.sign() * at.rng.uniform(0.008, 0.03)
    robot = with_truck(at.robot, truck, track=at.robot.trucks[truck].track * ratio)
    return FaultyRobot(
        robot, lambda _: [label("wheelbase", truck, {"ratio": ratio}, (("turn_scrub", truck),))]
    )


def wheel_misalignment(at: Setting) -> FaultyRobot:
    """Return a robot with an axle that is turned in its truck."""
    truck, angle = at.truck(), at.sign() * at.rng.uniform(0.005, 0.015)
    robot = with_truck(at.robot, truck, toe=angle)
    other = ("joint_bias", f"joint_{truck}")
    return FaultyRobot(robot, lambda _: [label("wheel_misalignment", truck, {"angle": angle}, (other,))])


def bump(at: Setting) -> FaultyRobot:
    """Return a robot that meets cables under one wheel in every lap."""
    wheel, height = at.wheel(), at.rng.uniform(0.005, 0.009)
    robot = replace(
        at.robot, cables=tuple(Cable(wheel, *place, height, 0.3) for place in _places(at, wheel, 4))
    )

    def labels_of(drive: Drive) -> list[dict[str, Any]]:
        spans, lost = crossings(drive, at.nominal, wheel, at.start)
        values = {"times": [first for first, _ in spans], "lost": lost}
        return [label("bump", wheel, values, (("slip_patch", wheel),), spans)]

    return FaultyRobot(robot, labels_of)


def _places(at: Setting, wheel: str, count: int) -> list[tuple[float, float, float]]:
    """Return places on a wheel's path where it rolls steadily [m], and directions across the path [rad]."""
    truck, side = WHEELS.index(wheel) // 2, 1 if wheel.endswith("left") else -1
    pose = at.healthy.poses[:, truck]
    half = side * at.nominal.tracks[truck] / 2
    x, y = pose[:, 0] - half * np.sin(pose[:, 2]), pose[:, 1] + half * np.cos(pose[:, 2])
    speed = np.diff(at.healthy.wheels[:, WHEELS.index(wheel)]) * at.nominal.radii[0] / at.healthy.time[1]
    yaw = np.diff(np.unwrap(pose[:, 2])) / at.healthy.time[1]
    rolling = (speed > 0.15) & (np.abs(yaw) < 0.35)
    steady = np.flatnonzero(np.convolve(~rolling, np.ones(121), "same") < 0.5)  # also 0.9 s before and after
    steady = steady if len(steady) > 500 else np.flatnonzero(rolling)
    rows = steady[
        np.linspace(0, len(steady) - 1, count + 2).astype(int)[1:-1] + at.rng.integers(-20, 20, count)
    ]
    return [(float(x[row]), float(y[row]), float(pose[row, 2] + np.pi / 2)) for row in rows]


def two_sizes(at: Setting) -> FaultyRobot:
    """Return a robot with a wheel of another diameter and another track on a truck."""
    first = wheel_diameter(at)
    second = wheelbase(replace(at, robot=first.robot))
    return FaultyRobot(
        second.robot, lambda run: [*first.labels_of(run), *second.labels_of(run)], kind="multi"
    )


def round_and_cables(at: Setting) -> FaultyRobot:
    """Return a robot with an eccentric wheel and cables under a wheel."""
    first = wheel_eccentricity(at)
    second = bump(replace(at, robot=first.robot))
    return FaultyRobot(
        second.robot, lambda run: [*first.labels_of(run), *second.labels_of(run)], kind="multi"
    )
