"""What may turn a robot of the hall sick, suddenly or gradually, and how its wheels then roll."""

import math
from dataclasses import dataclass
from typing import Annotated, Literal, get_args

from omnimate.vcan_sim.errors import SimulationError
from omnimate.vcan_sim.records import Constants, State
from omnimate.vehicle.compiled import Array, compiled

IllKind = Literal["wheel_diameter", "wheelbase", "joint_bias", "wheel_eccentricity", "gear_backlash"]
ILLS: tuple[IllKind, ...] = get_args(IllKind)


@dataclass(frozen=True, slots=True)
class Ill:
    """One thing that goes wrong with a robot from some day on.

    Attributes:
        kind: What goes wrong; the words are those of `docs/reference/diagnosis.md`.
        component: Wheel, truck or joint.
        day: First day on which it is there, from 0.
        size: How far it goes: a ratio's distance from 1 [1], an angle [rad], or an amplitude or play [m].
        days: Days in which it grows from nothing to its size, in proportion to time; 0 for suddenly.

    Raises:
        SimulationError: The kind is not known.
    """

    kind: IllKind
    component: str
    day: int
    size: float
    days: int = 0

    def __post_init__(self) -> None:
        if self.kind not in ILLS:
            raise SimulationError(f"an ill of kind {self.kind!r}; expected one of {', '.join(ILLS)}")

    def at(self, day: int) -> float:
        """Return how far it has gone on a day, in the unit of `size`."""
        since = day - self.day
        if since < 0:
            return 0.0
        return self.size * (min(1.0, (since + 1) / self.days) if self.days else 1.0)


class Wheels:
    """What a wheel does besides rolling, in the order of `WHEELS`.

    Attributes:
        amplitude: Amplitude of the rolling radius over a turn [m].
        play: Whole play between motor and wheel, as way of the wheel [m].
        motor: Way that the motor has turned the wheel's input [m].
        output: Way that the wheel has rolled behind its play [m].
    """

    amplitude: Annotated[Array, 4]
    play: Annotated[Array, 4]
    motor: Annotated[Array, 4]
    output: Annotated[Array, 4]


@compiled
def roll_sick(wheels: Wheels, constants: Constants, state: State) -> None:
    """Change the travel of wheels that run out of round, or behind a play, in this step."""
    for wheel in range(2 * constants.trucks):
        if wheels.amplitude[wheel] != 0.0:
            state.travel[wheel] += (
                wheels.amplitude[wheel] * math.cos(state.angle[wheel]) * state.turned[wheel]
            )
        if wheels.play[wheel] != 0.0:
            wheels.motor[wheel] += state.travel[wheel]
            half = 0.5 * wheels.play[wheel]
            rolled = min(max(wheels.output[wheel], wheels.motor[wheel] - half), wheels.motor[wheel] + half)
            state.travel[wheel] = rolled - wheels.output[wheel]
            wheels.output[wheel] = rolled
