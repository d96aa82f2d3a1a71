"""What a fault of the MuJoCo robot is built into, and what the result consists of."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from studies.mismatch.engines.mujoco.robot import WHEELS, Robot

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from studies.mismatch.engines.mujoco.drive import Hook, Scene
    from studies.mismatch.engines.mujoco.recording import Encoder
    from studies.mismatch.engines.true_motion import Drive, Nominal

    Values = dict[str, NDArray[np.float64]]
    Labels = Callable[[Drive], list[dict[str, Any]]]


def _unchanged(values: Values) -> Values:
    return values


@dataclass(frozen=True, slots=True)
class Setting:
    """What a fault is built into.

    Attributes:
        rng: Source of all that is drawn.
        robot: The healthy robot.
        healthy: The healthy robot's drive of the same program.
        nominal: The robot as `vehicle.toml` describes it.
        encoders: Encoders on the bus.
        start: Time of the first SYNC [s].
    """

    rng: np.random.Generator
    robot: Robot
    healthy: Drive
    nominal: Nominal
    encoders: tuple[Encoder, ...]
    start: float

    def sign(self) -> float:
        """Return +1 or -1, drawn at random."""
        return float(self.rng.choice([-1.0, 1.0]))

    def wheel(self) -> str:
        """Return a wheel, drawn at random."""
        return str(self.rng.choice(WHEELS))

    def truck(self) -> str:
        """Return a truck, drawn at random."""
        return str(self.rng.choice(["a", "b"]))

    def zero_angle(self, wheel: str) -> float:
        """Return the angle [rad] that a wheel's counter shows where the simulated angle is zero."""
        encoder = next(e for e in self.encoders if e.channel == wheel)
        return encoder.sign * encoder.start / encoder.per_unit


@dataclass(frozen=True, slots=True)
class FaultyRobot:
    """A robot with a fault.

    Attributes:
        robot: The robot as it is built.
        labels_of: Function that returns the labels of a drive of this robot.
        hooks: Functions that change the world during the drive.
        sense: Function that changes what the sensors read.
        kind: Kind of the case: null, single, multi, unknown or insufficient.
    """

    robot: Robot
    labels_of: Labels
    hooks: tuple[Hook, ...] = ()
    sense: Callable[[Values], Values] = _unchanged
    kind: str = "single"


def with_tyre(robot: Robot, wheel: str, **changes: float) -> Robot:
    """Return a robot with changed values of a wheel."""
    return replace(robot, tyres=robot.tyres | {wheel: replace(robot.tyres[wheel], **changes)})


def with_truck(robot: Robot, truck: str, **changes: float) -> Robot:
    """Return a robot with changed values of a truck."""
    return replace(robot, trucks=robot.trucks | {truck: replace(robot.trucks[truck], **changes)})


def pull(scene: Scene, truck: str, force: float, side: float) -> None:
    """Apply a force [N] against a truck's motion at its left (+1), right (-1) or middle (0)."""
    body = scene.data.body(truck)
    ahead = body.xmat.reshape(3, 3)[:, 0]
    speed = float(scene.data.joint(f"{truck}.left").qvel[0] + scene.data.joint(f"{truck}.right").qvel[0])
    push = -force * np.tanh(speed * 0.2)
    body.xfrc_applied[:3] = push * ahead
    body.xfrc_applied[3:] = (0, 0, -push * side * 0.2)


def yielding(robot: Robot, creep: float | None, trucks: str = "ab") -> Robot:
    """Return a robot with tyres that yield to forces, the more the longer the time constant `creep` [s].

    With None the tyres hold, and only oil under them (`contact.slippery`) lets them slide.
    """
    for wheel in WHEELS:
        if wheel[0] in trucks and creep is not None:
            robot = with_tyre(robot, wheel, creep=creep, impedance=0.6)
    return replace(robot, impratio=0.2)
