"""Reference offset: the body whose pose is measured is not mounted over the middle of the axle.

A marker or a prism is put on by hand, and its axes are those of the measuring system.

It is seen as a position that runs round the truck's when it turns, and as a truck that seems to travel at an
angle to its heading.

It is confused with a turned axle (wheel misalignment), unless a linkage shows the truck's heading.

The source is Censi, Franchi, Marchionni and Oriolo (2013), section II: the sensor's pose on the robot.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimate.effects.effect import TRUCK, Array, Block, Effect, Parameter, Prior
from omnimate.vehicle.se2 import compose, inverse

if TYPE_CHECKING:
    from collections.abc import Iterable


@dataclass(frozen=True, slots=True)
class ReferenceOffset(Effect):
    """The pose that is measured is that of a reference on the truck."""

    x: float = 0.0  # position of the reference ahead of the middle of the axle [m]
    y: float = 0.0  # position to the left of it [m]
    yaw: float = 0.0  # rotation of the reference, counter-clockwise [rad]

    name = "reference_offset"
    stage = "poses"
    components = TRUCK
    parameters = (
        Parameter("x", "m", null=0.0, scale=0.01, low=-5.0, high=5.0),
        Parameter("y", "m", null=0.0, scale=0.01, low=-5.0, high=5.0),
        Parameter("yaw", "rad", null=0.0, scale=0.0175, low=-3.2, high=3.2),
    )
    prior = Prior(1.0)
    searched = False
    is_setup = True

    @property
    def offset(self) -> Array:
        """Pose of the reference on the truck, shape `(3,)` [m, m, rad]."""
        return np.array([self.x, self.y, self.yaw])

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Return the block unchanged: only the measured poses change, see `measured`."""
        return block, state

    def measured(self, poses: Array) -> Array:
        """Return the measured poses `(..., 3)` of a truck at poses `(..., 3)`."""
        return compose(poses, self.offset)

    def truck(self, measured: Array) -> Array:
        """Return the truck's poses `(..., 3)` from measured ones `(..., 3)`: the inverse of `measured`."""
        return compose(measured, inverse(self.offset))


def truck_poses(effects: Iterable[Effect], truck: str, measured: Array) -> Array:
    """Return a truck's poses `(..., 3)` from measured poses `(..., 3)` of its reference."""
    for effect in effects:
        if isinstance(effect, ReferenceOffset) and effect.component == truck:
            measured = effect.truck(measured)
    return measured
