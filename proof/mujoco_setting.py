"""What a fault of the MuJoCo robot is put into, and what it is made of."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from proof.mujoco_robot import WHEELS, Robot

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from proof.mujoco_control import Nominal
    from proof.mujoco_drive import Drive, Hook, Scene
    from proof.mujoco_recording import Encoder

    Values = dict[str, NDArray[np.float64]]
    Labels = Callable[[Drive], list[dict[str, Any]]]


def _as_they_are(values: Values) -> Values:
    return values


@dataclass(frozen=True, slots=True)
class Setting:
    """What a fault is put into: the healthy robot and its drive, its nominal values, the clock's start."""

    rng: np.random.Generator
    robot: Robot
    healthy: Drive
    nominal: Nominal
    encoders: tuple[Encoder, ...]
    start: float

    def sign(self) -> float:
        """Return +1 or -1."""
        return float(self.rng.choice([-1.0, 1.0]))

    def wheel(self) -> str:
        """Return one wheel."""
        return str(self.rng.choice(WHEELS))

    def truck(self) -> str:
        """Return one truck."""
        return str(self.rng.choice(["a", "b"]))

    def zero_angle(self, wheel: str) -> float:
        """Return the angle that a wheel's counter has where the simulated angle is zero."""
        encoder = next(e for e in self.encoders if e.channel == wheel)
        return encoder.sign * encoder.start / encoder.per_unit


@dataclass(frozen=True, slots=True)
class Fault:
    """A robot with a fault; `sense` changes the readings, `tell` returns the labels of a drive."""

    robot: Robot
    tell: Labels
    hooks: tuple[Hook, ...] = ()
    sense: Callable[[Values], Values] = _as_they_are
    kind: str = "single"


def with_tyre(robot: Robot, wheel: str, **changes: float) -> Robot:
    """Return a robot with one wheel changed."""
    return replace(robot, tyres=robot.tyres | {wheel: replace(robot.tyres[wheel], **changes)})


def with_truck(robot: Robot, truck: str, **changes: float) -> Robot:
    """Return a robot with one truck changed."""
    return replace(robot, trucks=robot.trucks | {truck: replace(robot.trucks[truck], **changes)})


def pull(scene: Scene, truck: str, force: float, side: float) -> None:
    """Pull a truck back against its motion, at one of its sides (+1 left, -1 right, 0 the middle)."""
    body = scene.data.body(truck)
    ahead = body.xmat.reshape(3, 3)[:, 0]
    speed = float(scene.data.joint(f"{truck}.left").qvel[0] + scene.data.joint(f"{truck}.right").qvel[0])
    push = -force * np.tanh(speed * 0.2)
    body.xfrc_applied[:3] = push * ahead
    body.xfrc_applied[3:] = (0, 0, -push * side * 0.2)


def yielding(robot: Robot, creep: float | None, trucks: str = "ab") -> Robot:
    """Return a robot with tyres that give way to forces, the more the longer the time constant [s].

    Without one the tyres hold, and only a film under them (`mujoco_contact.slippery`) lets them slide.
    """
    for wheel in WHEELS:
        if wheel[0] in trucks and creep is not None:
            robot = with_tyre(robot, wheel, creep=creep, impedance=0.6)
    return replace(robot, impratio=0.2)
