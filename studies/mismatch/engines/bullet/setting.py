"""What a fault of a robot in PyBullet is built into, and what a fault consists of."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from studies.mismatch.engines.bullet.urdf import with_tread

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    import numpy as np

    from studies.mismatch.engines.bullet.chassis import Chassis
    from studies.mismatch.engines.bullet.drive import Hook
    from studies.mismatch.engines.bullet.floor import Box
    from studies.mismatch.engines.bullet.urdf import Place
    from studies.mismatch.engines.true_motion import Drive, Nominal

    Parameters = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Setting:
    """What a fault is built into.

    Attributes:
        chance: Source of all that is drawn.
        chassis: The healthy robot.
        nominal: The robot as `vehicle.toml` describes it.
        healthy: The healthy robot's drive of the course on a plane.
        start: Time of the first SYNC [s].
    """

    chance: np.random.Generator
    chassis: Chassis
    nominal: Nominal
    healthy: Drive
    start: float

    def sign(self) -> float:
        """Return +1 or -1, drawn at random."""
        return float(self.chance.choice([-1.0, 1.0]))

    def wheel(self) -> str:
        """Return a wheel, drawn at random."""
        return str(self.chance.choice(list(self.chassis.wheels)))

    def truck(self) -> str:
        """Return a truck, drawn at random."""
        return str(self.chance.choice(list("ab"[: self.chassis.trucks])))

    def moment(self, first: float, last: float) -> float:
        """Return a time of the drive [s] between two shares of its duration, drawn at random."""
        return float(self.healthy.time[-1] * self.chance.uniform(first, last))


def _unchanged(chassis: Chassis) -> Chassis:
    return chassis


@dataclass(frozen=True, slots=True)
class Fault:
    """A fault of a robot.

    Attributes:
        effect: Its name in the vocabulary, or "unknown".
        component: Component on which it acts.
        measure: Function that returns its parameters, as a drive with the fault on a plane shows them.
        build: Function that builds it into a robot.
        boxes: Boxes that it lays on the floor.
        hooks: Functions that change the world during the drive.
        sensed: Parameters of a fault of an encoder; None where it acts on the motion.
        intervals: Function that returns the intervals in which it acts [s], of the drive that is recorded.
    """

    effect: str
    component: str
    measure: Callable[[Drive], Parameters]
    build: Callable[[Chassis], Chassis] = _unchanged
    boxes: tuple[Box, ...] = ()
    hooks: tuple[Hook, ...] = ()
    sensed: Parameters | None = None
    intervals: Callable[[Drive], list[list[float]]] | None = None


def with_treads(
    chassis: Chassis,
    channel: str,
    radius: float,
    off_axle: Place = (0.0, 0.0, 0.0),
    links: Sequence[str] = (),
) -> Chassis:
    """Return a robot with other treads on the wheels of a channel, or on some links of them."""
    urdf = chassis.urdf
    for name in links or chassis.wheels[channel].links:
        urdf = with_tread(urdf, name, radius, off_axle)
    return replace(chassis, urdf=urdf)
