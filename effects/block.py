"""The signals of successive steps of a robot, the input and output of effects.

A step is the interval between two samples. The simulator passes blocks of one step, the diagnosis whole
recordings; effects with memory receive their state from the previous block.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Self

import numpy as np

from omnimate.vehicle.parameters import WHEELS

if TYPE_CHECKING:
    from omnimate.vehicle.se2 import Array


@dataclass(frozen=True, slots=True)
class Block:
    """K steps of a robot with T trucks and W = 2 T wheels, in the order of `WHEELS`."""

    time: Array  # time at the end of each step, `(K,)` [s]
    period: Array  # duration of each step, `(K,)` [s]
    angle: Array  # angle of each wheel at the end of the step, from its raw counter's zero, `(K, W)` [rad]
    turned: Array  # angle by which each wheel turned in the step, `(K, W)` [rad]
    speed: Array  # nominal rolling speed of each wheel, `(K, W)` [m/s]
    acceleration: Array  # rate of change of the nominal rolling speed, `(K, W)` [m/s^2]
    wheelbase: Array  # nominal wheelbase of each truck, `(T,)` [m]
    heading: Array  # heading of each truck in the world, in the middle of the step, `(K, T)` [rad]
    place: Array  # position of each truck in the world, in the middle of the step, `(K, T, 2)` [m]
    travel: Array  # travel of each wheel over the ground in the step, `(K, W)` [m]
    twist: Array  # of each truck, in its frame, `(K, T, 3)`: forward [m], creep to the left [m], yaw [rad]
    # Readings of joint_a [rad], joint_b [rad] and link [m] at the end of the step, `(K, 3)`; no columns with
    # a single truck. The link's reading is its length
    reading: Array
    rest: float = 0.0  # length at which the link reads its zero [m]

    def __len__(self) -> int:
        return len(self.time)

    def between(self, first: int, last: int) -> Self:
        """Return the steps from number `first` up to but not including `last`."""
        signals = (field.name for field in fields(self) if field.name not in {"wheelbase", "rest"})
        return replace(self, **{name: getattr(self, name)[first:last] for name in signals})

    def with_travel(self, wheel: int, travel: Array) -> Self:
        """Return the block with another travel `(K,)` of one wheel [m]."""
        changed = self.travel.copy()
        changed[:, wheel] = travel
        return replace(self, travel=changed)

    def with_counted(self, wheel: int, angle: Array, turned: Array) -> Self:
        """Return the block with another counted angle and turn `(K,)` of one wheel [rad]."""
        angles, turns = self.angle.copy(), self.turned.copy()
        angles[:, wheel], turns[:, wheel] = angle, turned
        return replace(self, angle=angles, turned=turns)

    def with_twist(self, truck: int, twist: Array) -> Self:
        """Return the block with another twist `(K, 3)` of one truck."""
        changed = self.twist.copy()
        changed[:, truck] = twist
        return replace(self, twist=changed)

    def with_reading(self, channel: int, reading: Array) -> Self:
        """Return the block with another reading `(K,)` of joint_a, joint_b or link, 0 to 2."""
        changed = self.reading.copy()
        changed[:, channel] = reading
        return replace(self, reading=changed)

    def rolled(self) -> Self:
        """Return the block with twists calculated from the wheels' travel, U (2.4)-(2.6)."""
        left, right = self.travel[:, 0::2], self.travel[:, 1::2]
        twist = np.zeros((*left.shape, 3))
        twist[..., 0] = 0.5 * (left + right)
        twist[..., 2] = (right - left) / self.wheelbase
        return replace(self, twist=twist)


LINKAGE = ("joint_a", "joint_b", "link")


def wheel_radius(block: Block, wheel: int) -> float:
    """Return a wheel's nominal radius [m]: travel over turn, or 75 mm (assumption) if it did not turn."""
    turned = np.abs(block.turned[:, wheel]).sum()
    return float(np.abs(block.travel[:, wheel]).sum() / turned) if turned > 0.0 else 0.075


def wheel_number(component: str) -> int:
    """Return the column of a wheel."""
    wheels: tuple[str, ...] = WHEELS
    return wheels.index(component)


def truck_number(component: str) -> int:
    """Return the column of a truck, "a" or "b"."""
    return ("a", "b").index(component)


def wheel_columns(component: str) -> tuple[int, ...]:
    """Return the columns of a wheel, or of both wheels of a truck."""
    if component in LINKAGE:
        return ()
    if "." in component:
        return (wheel_number(component),)
    truck = truck_number(component)
    return 2 * truck, 2 * truck + 1
