"""Faults of encoders, and what encoders make of a drive: ways, readings and counts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from studies.mismatch.engines.bullet.setting import Fault
from studies.mismatch.engines.engine import Drive as Recorded
from studies.mismatch.engines.robots import WHEELS, Robot
from studies.mismatch.engines.strength.drive import Drive as Seen
from studies.mismatch.engines.strength.drive import Poses
from studies.mismatch.engines.writing import Measuring, measured

if TYPE_CHECKING:
    from studies.mismatch.engines.bullet.setting import Setting
    from studies.mismatch.engines.true_motion import Drive

Laps = list[tuple[str, float, float]]


def joint_bias(at: Setting) -> Fault:
    """Return a joint encoder that is mounted at an angle."""
    return _sensed("joint_bias", _joint(at), bias=at.sign() * at.chance.uniform(0.003, 0.01))


def joint_eccentricity(at: Setting) -> Fault:
    """Return a joint encoder whose disc is off the joint's centre."""
    amplitude, phase = at.chance.uniform(0.004, 0.015), at.chance.uniform(-np.pi, np.pi)
    return _sensed("joint_eccentricity", _joint(at), amplitude=amplitude, phase=phase)


def joint_backlash(at: Setting) -> Fault:
    """Return a joint encoder with play."""
    return _sensed("joint_backlash", _joint(at), width=at.chance.uniform(0.01, 0.03))


def link_bias(at: Setting) -> Fault:
    """Return a linear encoder that is not mounted where `vehicle.toml` says."""
    return _sensed("link_bias", "link", bias=at.sign() * at.chance.uniform(0.003, 0.01))


def count_loss(at: Setting) -> Fault:
    """Return a wheel whose counts are lost above a speed."""
    wheel = at.wheel()
    column = WHEELS.index(wheel)
    speed = np.abs(np.gradient(at.healthy.wheels[:, column], at.healthy.time)) * at.nominal.radii[column]
    above = float(at.chance.uniform(0.4, 0.8) * np.quantile(speed, 0.95))
    return _sensed("count_loss", wheel, fraction=at.chance.uniform(0.004, 0.015), above=above)


def latency(at: Setting) -> Fault:
    """Return an encoder whose samples are old."""
    channels = [*at.chassis.wheels, *(("joint_a", "joint_b") if at.chassis.link else ())]
    return _sensed("latency", str(at.chance.choice(channels)), delay=at.chance.uniform(0.03, 0.09))


def _joint(at: Setting) -> str:
    return str(at.chance.choice(["joint_a", "joint_b"]))


def _sensed(effect: str, component: str, **parameters: float) -> Fault:
    return Fault(effect, component, lambda _: dict(parameters), sensed=parameters)


def seen(robot: Robot, drive: Drive, start: float, laps: Laps, measuring: Measuring | None) -> Seen:
    """Return a drive as sensors without any error see it, and poses as they are.

    Args:
        robot: The robot as its owner believes it to be.
        drive: What happened.
        start: Time of the first SYNC [s].
        laps: Laps as (direction, start [s], end [s]).
        measuring: How poses are measured; None for not at all.
    """
    radius = np.array(robot.radius)
    wheels = [device for device in robot.devices if device.channel in WHEELS]
    count = np.array([2.0 * np.pi / device.resolution for device in wheels]) * radius
    reading = (
        np.column_stack([drive.joints, drive.link]) if robot.trucks == 2 else np.zeros((len(drive.time), 0))
    )
    happened = Recorded(drive.time + start, np.zeros((0, 0), np.int64), drive.poses, laps)
    rows = [] if measuring is None else list(measured(robot, happened, measuring, None))
    poses = {
        truck: Poses(*(np.array([row[item] for row in rows if row[1] == truck]) for item in (0, 2)))
        for truck in sorted({truck for _, truck, _ in rows})
    }
    return Seen(
        drive.time + start,
        drive.wheels * radius,
        count,
        radius,
        np.array(robot.wheelbase),
        reading,
        robot.length,
        poses,
    )


def recorded(robot: Robot, ways: Seen, drive: Drive, laps: Laps, chance: np.random.Generator) -> Recorded:
    """Return a drive as it is recorded: the ways and readings that sensors see, in counts.

    Args:
        robot: The robot as its owner believes it to be.
        ways: What its sensors see.
        drive: What happened.
        laps: Laps as (direction, start [s], end [s]).
        chance: Source of the scatter of the linkage's readings.
    """
    counts = []
    for device in robot.devices:
        if device.channel in WHEELS:
            column = WHEELS.index(device.channel)
            turns = ways.way[:, column] / (2.0 * np.pi * robot.radius[column])
        elif device.channel == "link":
            turns = ways.reading[:, 2] - robot.length
        else:
            turns = ways.reading[:, ("joint_a", "joint_b").index(device.channel)] / (2.0 * np.pi)
        jitter = 0.0 if device.channel in WHEELS else robot.jitter * chance.normal(size=len(turns))
        counts.append(
            device.zero + device.sign * np.rint(turns * device.resolution + jitter).astype(np.int64)
        )
    return Recorded(ways.time, np.stack(counts, axis=1), drive.poses, laps)
