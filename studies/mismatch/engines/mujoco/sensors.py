"""Faults in the mounting of a MuJoCo robot's encoders."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from studies.mismatch.engines.mujoco.labels import label
from studies.mismatch.engines.mujoco.setting import FaultyRobot

if TYPE_CHECKING:
    from studies.mismatch.engines.mujoco.setting import Setting, Values


def joint_bias(at: Setting) -> FaultyRobot:
    """Return a robot with a joint encoder that is mounted at an angle."""
    joint, bias = str(at.rng.choice(["joint_a", "joint_b"])), at.sign() * at.rng.uniform(0.002, 0.008)
    other = ("wheel_misalignment", joint[-1])
    return FaultyRobot(
        at.robot,
        lambda _: [label("joint_bias", joint, {"bias": bias}, (other,))],
        sense=lambda values: values | {joint: values[joint] + bias},
    )


def joint_eccentricity(at: Setting) -> FaultyRobot:
    """Return a robot with the disc of a joint encoder off the joint's centre."""
    offset, bearing = at.rng.uniform(0.003, 0.01), at.rng.uniform(-np.pi, np.pi)

    def sense(values: Values) -> Values:
        angle = values["joint_a"]
        seen = np.exp(1j * angle) + offset * np.exp(1j * bearing)
        return values | {"joint_a": angle + np.angle(seen * np.exp(-1j * angle))}

    phase = float(np.angle(np.exp(1j * (np.pi / 2 - bearing))))
    values = {"amplitude": offset, "phase": phase}
    return FaultyRobot(
        at.robot,
        lambda _: [label("joint_eccentricity", "joint_a", values, (("joint_bias", "joint_a"),))],
        sense=sense,
    )


def link_bias(at: Setting) -> FaultyRobot:
    """Return a robot with a linear encoder that is not mounted where `vehicle.toml` says."""
    bias = at.sign() * at.rng.uniform(0.002, 0.006)
    sense = lambda values: values | {"link": values["link"] + bias}  # noqa: E731  # short enough for one line
    return FaultyRobot(at.robot, lambda _: [label("link_bias", "link", {"bias": bias})], sense=sense)
