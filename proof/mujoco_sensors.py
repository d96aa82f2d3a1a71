"""Faults of encoders that a MuJoCo robot carries: how they are mounted, not what they measure."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from proof.mujoco_labels import label
from proof.mujoco_setting import Fault

if TYPE_CHECKING:
    from proof.mujoco_setting import Setting, Values


def joint_bias(at: Setting) -> Fault:
    """A joint encoder mounted at an angle."""
    joint, bias = str(at.rng.choice(["joint_a", "joint_b"])), at.sign() * at.rng.uniform(0.002, 0.008)
    other = ("wheel_misalignment", joint[-1])
    return Fault(
        at.robot,
        lambda _: [label("joint_bias", joint, {"bias": bias}, (other,))],
        sense=lambda values: values | {joint: values[joint] + bias},
    )


def joint_eccentricity(at: Setting) -> Fault:
    """A joint encoder's disc off the joint's centre: the head reads the angle seen from the joint."""
    offset, bearing = at.rng.uniform(0.003, 0.01), at.rng.uniform(-np.pi, np.pi)

    def sense(values: Values) -> Values:
        angle = values["joint_a"]
        seen = np.exp(1j * angle) + offset * np.exp(1j * bearing)
        return values | {"joint_a": angle + np.angle(seen * np.exp(-1j * angle))}

    phase = float(np.angle(np.exp(1j * (np.pi / 2 - bearing))))
    values = {"amplitude": offset, "phase": phase}
    return Fault(
        at.robot,
        lambda _: [label("joint_eccentricity", "joint_a", values, (("joint_bias", "joint_a"),))],
        sense=sense,
    )


def link_bias(at: Setting) -> Fault:
    """A linear encoder fixed in another place than its owner believes."""
    bias = at.sign() * at.rng.uniform(0.002, 0.006)
    sense = lambda values: values | {"link": values["link"] + bias}  # noqa: E731 - one line says it
    return Fault(at.robot, lambda _: [label("link_bias", "link", {"bias": bias})], sense=sense)
