"""The variables on which a law may depend: the motion of a robot at each step, in SI units.

They are those of the nominal robot: speeds follow from the wheels' turns, joints and link are as read.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np

from omnimate.effects.block import LINKAGE, truck_number, wheel_columns
from omnimate.effects.errors import EffectError
from omnimate.vehicle.compiled import compiled
from omnimate.vehicle.parameters import WHEELS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from numpy.typing import NDArray

    from omnimate.effects.block import Block
    from omnimate.vehicle.se2 import Array

Number = TypeVar("Number", np.float64, np.complex128)


class MotionState(NamedTuple):
    """State of a component's motion before a block."""

    start: float  # time at the start of the drive [s]
    way: float  # distance rolled since then, forward and back [m]
    past: float = 0.0  # weighted mean of earlier accelerations [m/s^2], see `past_acceleration`
    warmth: float = 0.0  # likewise of earlier speeds [m/s], see `recent_speed`
    rolled: float = 0.0  # likewise of the directions in which it rolled, see `rolling_on`
    turned: float = 0.0  # likewise of the directions of its turns, see `turning_on`


PAST_ACCELERATION_TIME = 1.0  # [s] time constant of `past_acceleration`: longer than a change of speed
RECENT_SPEED_TIME = 30.0  # [s] time constant of `recent_speed`: a tyre warms up in a minute or two
ROLLED_DISTANCE = 0.01  # [m] that is remembered by `rolling_on`: several times the play of a gear
TURNED_ANGLE = 0.3  # [rad] that is remembered by `turning_on`: it winds up a tyre's contact patch


class Motion:
    """Motion of one component (a wheel, truck, joint or link) in the steps of a block.

    `begun` is its state before the block, `truck` the column of its truck; that of joint_a and link is a.
    """

    def __init__(self, block: Block, component: str, begun: MotionState | None = None) -> None:
        self.block, self.component = block, component
        self.begun = begun or MotionState(float(block.time[0] - block.period[0]), 0.0)
        self.truck = int(component == "joint_b") if component in LINKAGE else truck_number(component[0])

    def values(self, names: Iterable[str]) -> dict[str, Array]:
        """Return variables by name, each of shape `(K,)`.

        Raises:
            EffectError: There is no such variable, or this robot or component does not have it.
        """
        there = available_variables(self.component, trucks=self.block.speed.shape[1] // 2)
        for name in names:
            if name not in there:
                raise EffectError(
                    f"variable {name!r} of {self.component}; expected one of {', '.join(there)}"
                )
        return {name: there[name].of(self) for name in names}

    def after(self) -> MotionState:
        """Return the state of the motion at the end of the block."""
        return self.begun._replace(
            way=float(self.way[-1]),
            past=float(self.past_acceleration[-1]),
            warmth=float(self.recent_speed[-1]),
            rolled=float(self._rolled[-1]),
            turned=float(self._turned[-1]),
        )

    @property
    def speeds(self) -> Array:
        """Speeds of the trucks [m/s], shape `(K, T)`."""
        return np.asarray(0.5 * (self.block.speed[:, 0::2] + self.block.speed[:, 1::2]))

    @property
    def turn_rates(self) -> Array:
        """Turn rates of the trucks [rad/s], shape `(K, T)`."""
        return np.asarray((self.block.speed[:, 1::2] - self.block.speed[:, 0::2]) / self.block.wheelbase)

    @property
    def yaw_accelerations(self) -> Array:
        """Yaw accelerations of the trucks [rad/s^2], shape `(K, T)`."""
        acceleration = self.block.acceleration
        return np.asarray((acceleration[:, 1::2] - acceleration[:, 0::2]) / self.block.wheelbase)

    @property
    def joint_rates(self) -> Array:
        """Rates of joint_a and joint_b as the trucks move them [rad/s], shape `(K, 2)`."""
        return np.asarray(self.turn_rates - self.link_yaw_rate[:, None])

    @property
    def link_yaw_rate(self) -> Array:
        """Turn rate of the line between the trucks [rad/s]."""
        across = self.speeds * np.sin(self.block.reading[:, :2])
        return np.asarray((across[:, 0] - across[:, 1]) / self.block.reading[:, 2])

    @property
    def link_yaw_acceleration(self) -> Array:
        """Rate of change of the link's turn rate, its length taken as constant [rad/s^2]."""
        joints = self.block.reading[:, :2]
        acceleration = 0.5 * (self.block.acceleration[:, 0::2] + self.block.acceleration[:, 1::2])
        across = acceleration * np.sin(joints) + self.speeds * np.cos(joints) * self.joint_rates
        return np.asarray((across[:, 0] - across[:, 1]) / self.block.reading[:, 2])

    @property
    def link_rate(self) -> Array:
        """Rate of the link's length as the trucks move it [m/s]."""
        along = self.speeds * np.cos(self.block.reading[:, :2])
        return np.asarray(along[:, 0] - along[:, 1])

    @property
    def way(self) -> Array:
        """Distance rolled since the start, forward and back [m]."""
        return np.asarray(self.begun.way + np.cumsum(np.abs(self.mean(self.block.speed)) * self.block.period))

    @property
    def past_acceleration(self) -> Array:
        """Mean of the accelerations so far, with exponentially falling weights [m/s^2]."""
        acceleration = self.mean(self.block.acceleration)
        return recent_mean(self.block.period, acceleration, PAST_ACCELERATION_TIME, self.begun.past)

    @property
    def recent_speed(self) -> Array:
        """Mean of the speeds so far, forward and back, with exponentially falling weights [m/s]."""
        speed = np.abs(self.mean(self.block.speed))
        return recent_mean(self.block.period, speed, RECENT_SPEED_TIME, self.begun.warmth)

    @property
    def rolling_on(self) -> Array:
        """How far it rolls on as it rolled before: from -1 after a reversal to 1; 0 where it stands."""
        return np.asarray(np.sign(self.mean(self.block.speed)) * self._rolled)

    @property
    def turning_on(self) -> Array:
        """How far the truck turns on as it turned before, likewise."""
        return np.asarray(np.sign(self.turn_rates[:, self.truck]) * self._turned)

    @property
    def _rolled(self) -> Array:
        way = self.mean(self.block.speed) * self.block.period
        return recent_direction(way, ROLLED_DISTANCE, self.begun.rolled)

    @property
    def _turned(self) -> Array:
        turn = self.turn_rates[:, self.truck] * self.block.period
        return recent_direction(turn, TURNED_ANGLE, self.begun.turned)

    def mean(self, signal: Array) -> Array:
        """Return a signal `(K, W)` of the component's wheel, or the mean of its truck's wheels."""
        wheels = wheel_columns(self.component) or (2 * self.truck, 2 * self.truck + 1)
        return np.asarray(signal[:, wheels].mean(axis=1))

    def angle(self, wheel: int) -> Array:
        """Return the angle of a wheel in the middle of each step [rad]."""
        return np.asarray(self.block.angle[:, wheel] - 0.5 * self.block.turned[:, wheel])


def recent_mean(steps: Array, values: Array, length: float, start: float = 0.0) -> Array:
    """Return the mean of values (K,) so far, forgotten exponentially over a length in the steps' unit.

    `steps` (K,) are the time, way or angle between the values; `start` is the mean before the first.
    """
    kept = np.exp(-steps / length)
    return decaying_sum(kept, (1.0 - kept) * values, start)


def recent_direction(moves: Array, length: float, start: float = 0.0) -> Array:
    """Return the direction of the moves (K,) of late, from -1 to 1: the state of Dahl's friction (1968)."""
    return recent_mean(np.abs(moves), np.sign(moves), length, start)


@compiled
def decaying_sum(kept: NDArray[Number], gained: NDArray[Number], start: complex) -> NDArray[Number]:
    """Return y (K,) with y[k] = kept[k] y[k - 1] + gained[k]; the type of `start` is that of y's members."""
    values, last = np.empty_like(gained), start
    for step in range(len(gained)):
        last = kept[step] * last + gained[step]
        values[step] = last
    return values


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable on which a law may depend."""

    unit: str  # SI unit; "rad" for an angle
    about: str
    of: Callable[[Motion], Array]  # function from a component's motion to the variable, `(K,)`


WHEEL_ANGLE = "wheel_angle"


def _wheel(number: int) -> Variable:
    return Variable(
        "rad", f"angle of {WHEELS[number]} from its raw counter's zero", lambda motion: motion.angle(number)
    )


VARIABLES: dict[str, Variable] = {
    "speed": Variable("m/s", "rolling speed of the wheel or truck", lambda m: m.mean(m.block.speed)),
    "acceleration": Variable("m/s^2", "rate of change of it", lambda m: m.mean(m.block.acceleration)),
    "past_acceleration": Variable("m/s^2", "mean of the accelerations of the last seconds",
        lambda m: m.past_acceleration),
    "recent_speed": Variable("m/s", "mean of the speeds of the last half minute, forward and back",
        lambda m: m.recent_speed),
    "rolling_on": Variable("1", "whether it rolls on as in the last 10 mm: -1 after a reversal, "
        "then up to 1; 0 where it stands", lambda m: m.rolling_on),
    "turning_on": Variable("1", "whether the truck turns on as in the last 0.3 rad: -1 after a reversal, "
        "then up to 1; 0 where it does not turn", lambda m: m.turning_on),
    "turn_rate": Variable("rad/s", "turn rate of the truck, to the left", lambda m: m.turn_rates[:, m.truck]),
    "yaw_acceleration": Variable("rad/s^2", "rate of change of it",
        lambda m: m.yaw_accelerations[:, m.truck]),
    "load": Variable("m/s^2", "centripetal acceleration of the truck: its speed times its turn rate, "
        "in proportion to the load that moves to the outer wheel",
        lambda m: m.speeds[:, m.truck] * m.turn_rates[:, m.truck]),
    "way": Variable("m", "way rolled since the start, forward and back", lambda m: m.way),
    "time": Variable("s", "time since the start", lambda m: m.block.time - m.begun.start),
    "heading": Variable("rad", "heading of the truck", lambda m: m.block.heading[:, m.truck]),
    "x": Variable("m", "position of the truck in the world", lambda m: m.block.place[:, m.truck, 0]),
    "y": Variable("m", "position of the truck in the world", lambda m: m.block.place[:, m.truck, 1]),
    WHEEL_ANGLE: Variable("rad", "of a wheel alone: its angle from its raw counter's zero",
        lambda m: m.angle(wheel_columns(m.component)[0])),
    **{f"wheel_angle_{wheel.replace('.', '_')}": _wheel(number) for number, wheel in enumerate(WHEELS)},
    "joint_a": Variable("rad", "angle of the joint on truck a, as read", lambda m: m.block.reading[:, 0]),
    "joint_b": Variable("rad", "angle of the joint on truck b, as read", lambda m: m.block.reading[:, 1]),
    "link": Variable("m", "length of the link, as read", lambda m: m.block.reading[:, 2]),
    "joint_a_rate": Variable("rad/s", "rate of joint_a, as the trucks move it",
        lambda m: m.joint_rates[:, 0]),
    "joint_b_rate": Variable("rad/s", "rate of joint_b, as the trucks move it",
        lambda m: m.joint_rates[:, 1]),
    "link_rate": Variable("m/s", "rate of the link's length, as the trucks move it",
        lambda m: m.link_rate),
    "link_yaw_rate": Variable("rad/s", "turn rate of the line between the trucks",
        lambda m: m.link_yaw_rate),
    "link_yaw_acceleration": Variable("rad/s^2", "rate of change of it",
        lambda m: m.link_yaw_acceleration),
}  # fmt: skip


def available_variables(component: str, trucks: int = 2) -> dict[str, Variable]:
    """Return the variables that a component has, by name, in a robot with one truck or two."""
    absent = set() if "." in component else {WHEEL_ANGLE}
    if trucks == 1:
        absent |= {
            *(name for name in VARIABLES if name.startswith(("joint", "link"))),
            "wheel_angle_b_left",
            "wheel_angle_b_right",
        }
    return {name: variable for name, variable in VARIABLES.items() if name not in absent}
