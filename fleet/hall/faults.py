"""Faults of the hall's robots, sudden or gradual, and the travel of faulty wheels."""

import math
from dataclasses import dataclass
from typing import Annotated, Literal, get_args

import numpy as np

from omnimate.vcan_sim.errors import SimulationError
from omnimate.vcan_sim.records import Constants, State
from omnimate.vehicle.compiled import Array, compiled

FaultKind = Literal["wheel_diameter", "wheelbase", "joint_bias", "wheel_eccentricity", "gear_backlash"]
FAULTS: tuple[FaultKind, ...] = get_args(FaultKind)
_GROWTH_DAYS = 10  # [days] in which a gradual fault grows to its size, at most (assumption)
# For each kind: components of a single-truck robot, of a two-truck robot, and range of the size. Assumptions.
_RANGES: dict[FaultKind, tuple[tuple[str, ...], tuple[str, ...], float, float]] = {
    "wheel_diameter": (("a.left", "a.right"), ("a.left", "a.right"), 8e-4, 3e-3),
    "wheelbase": (("a",), ("a",), 1e-2, 4e-2),
    "joint_bias": ((), ("joint_a", "joint_b"), 5e-3, 2e-2),
    "wheel_eccentricity": ((), ("a.left", "a.right"), 3e-4, 1e-3),
    "gear_backlash": ((), ("a.left", "a.right"), 5e-4, 3e-3),
}


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault of a robot, from some day on.

    Raises:
        SimulationError: The kind is not known.
    """

    kind: FaultKind  # kind of the fault, as in `docs/reference/diagnosis.md`
    component: str  # wheel, truck or joint, such as `a.left`, `a` or `joint_a`
    day: int  # first day of the fault, from 0
    # its size: relative change of a diameter or wheelbase [1], bias of a joint [rad], amplitude of the
    # rolling radius [m], or backlash as travel of the wheel [m]
    size: float
    days: int = 0  # days in which it grows from 0 to its size, in proportion to time; 0 for a sudden one

    def __post_init__(self) -> None:
        if self.kind not in FAULTS:
            raise SimulationError(f"a fault of kind {self.kind!r}; expected one of {', '.join(FAULTS)}")

    def at(self, day: int) -> float:
        """Return its size on a day, in the unit of `size`."""
        since = day - self.day
        if since < 0:
            return 0.0
        return self.size * (min(1.0, (since + 1) / self.days) if self.days else 1.0)


def draw_fault(kind: str, days: int, chance: np.random.Generator) -> Fault:
    """Return a random fault of a robot of a type (`TYPES`) in a simulation of `days` days."""
    column = 1 if kind == "train" else 0
    possible = [name for name, ranges in _RANGES.items() if ranges[column]]
    name = possible[int(chance.integers(len(possible)))]
    components, (low, high) = _RANGES[name][column], _RANGES[name][2:]
    size = chance.uniform(low, high) * (chance.choice([-1.0, 1.0]) if "wheel_e" not in name else 1.0)
    if name == "gear_backlash":
        size = abs(size)
    first, last = max(1, days // 5), max(2, days - 5)
    day = int(chance.integers(first, last))
    gradual = int(chance.integers(2)) * min(_GROWTH_DAYS, max(2, days // 3))
    return Fault(name, str(chance.choice(components)), day, float(size), gradual)


class WheelFaults:
    """Faults of wheels, and their state, in the order of `WHEELS`."""

    amplitude: Annotated[Array, 4]  # amplitude of the rolling radius over a turn of an eccentric wheel [m]
    backlash: Annotated[Array, 4]  # backlash between motor and wheel, end to end, as travel of the wheel [m]
    motor: Annotated[Array, 4]  # travel of the motor, as travel of the wheel without backlash [m]
    output: Annotated[Array, 4]  # travel of the wheel [m]


@compiled
def apply_wheel_faults(wheels: WheelFaults, constants: Constants, state: State) -> None:
    """Change the travel of eccentric wheels, and of wheels with backlash, in this step."""
    for wheel in range(2 * constants.trucks):
        if wheels.amplitude[wheel] != 0.0:
            state.travel[wheel] += (
                wheels.amplitude[wheel] * math.cos(state.angle[wheel]) * state.turned[wheel]
            )
        if wheels.backlash[wheel] != 0.0:
            wheels.motor[wheel] += state.travel[wheel]
            half = 0.5 * wheels.backlash[wheel]
            rolled = min(max(wheels.output[wheel], wheels.motor[wheel] - half), wheels.motor[wheel] + half)
            state.travel[wheel] = rolled - wheels.output[wheel]
            wheels.output[wheel] = rolled
