"""Law: an error of a component that no other effect describes, as a formula or a curve of variables.

A diagnosis learns it from what is left over. The error is f = formula + curve, where the curve runs straight
from knot to knot, and is constant beyond the first and the last one unless it has a period.

A wheel travels (1 + f) of what it would. A truck goes f further forward, creeps to the left by f or yaws by f
per metre that it goes forward or back, or it turns by (1 + f) of what it would. A joint or the link reads f
more.

It is seen as whatever its formula says.

It is confused with any named effect, which is therefore searched first.

The source is the equation that a diagnosis learned, or that its user wrote.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimate.effects.block import LINKAGE, truck_number, wheel_number
from omnimate.effects.effect import JOINT, LINK, RARE, TRUCK, WHEEL, Effect, Parameter, Prior, Text
from omnimate.effects.errors import EffectError
from omnimate.effects.expression import parse
from omnimate.effects.variables import Motion, available_variables
from omnimate.effects.words import component_in_words

if TYPE_CHECKING:
    from omnimate.effects.effect import Array, Block, Stage, VehicleParameters
    from omnimate.effects.variables import MotionState

STAGE_OF: dict[str, Stage] = {"travel": "travel", "reading": "reading"}  # all others act on the body
TWIST = {"forward": 0, "creep": 1, "yaw": 2, "turn": 2}  # column of a truck's motion
WHAT_IT_DOES = {  # of what a law acts on
    "reading": "reads f {unit} more",
    "travel": "travels (1 + f) of what it would",
    "forward": "goes f further forward per metre",
    "creep": "creeps to the left by f per metre",
    "yaw": "yaws by f rad per metre",
    "turn": "turns by (1 + f) of what it would",
}


def law_quantities(component: str) -> dict[str, str]:
    """Return the quantities that a law may act on, with the unit of f; the first is the default."""
    if component in WHEEL:
        return {"travel": "1"}
    if component in TRUCK:
        return {"yaw": "rad/m", "turn": "1", "creep": "1", "forward": "1"}
    return {"reading": "rad" if component in JOINT else "m"}


@dataclass(frozen=True, slots=True)
class Law(Effect):
    """An error that is a formula, a curve over one variable, or the sum of both.

    Raises:
        EffectError: The quantity or a variable is not one of the component's, the formula is none, or
            knots and ordinates make no curve.
    """

    acts_on: str = ""  # quantity of the component, one of `law_quantities`; empty for the first
    formula: str = "0"  # formula of the variables, in the grammar of `effects.expression`
    over: str = ""  # variable over which the curve is; empty without a curve
    knots: tuple[float, ...] = ()  # values of that variable, ascending; none without a curve
    ordinates: tuple[float, ...] = ()  # value of the curve at each knot
    period: float = 0.0  # period of the curve, in the variable's unit; 0 where it has none

    name = "law"
    stage = "travel"
    components = (*WHEEL, *TRUCK, *JOINT, *LINK)
    parameters = (
        Parameter("knots", "the variable's", null=None, scale=1.0, low=-1e12, high=1e12),
        Parameter("ordinates", "that of f", null=None, scale=1e-3, low=-1.0, high=1.0),
        Parameter("period", "the variable's", null=None, scale=1.0, low=0.0, high=1e12),
    )
    prior = Prior(RARE, background=0.0, discrepancy=0.1)
    texts = (
        Text(
            "acts_on",
            "`travel`; of a truck `yaw`, `turn`, `creep` or `forward`; of joints and link `reading`",
        ),
        Text("formula", "a formula of the variables; `0` where none is given"),
        Text("over", "variable over which the curve is"),
    )
    searched = False

    def __post_init__(self) -> None:
        Effect.__post_init__(self)
        there = law_quantities(self.component)
        object.__setattr__(self, "acts_on", self.acts_on or next(iter(there)))
        if self.acts_on not in there:
            raise self._error(f"acts_on = {self.acts_on!r}; expected one of {', '.join(there)}")
        for name in sorted(self._variables()):
            if name not in available_variables(self.component):
                raise self._error(
                    f"variable {name!r}; expected one of {', '.join(available_variables(self.component))}"
                )
        if len(self.knots) != len(self.ordinates):
            raise self._error(f"{len(self.knots)} knots, {len(self.ordinates)} ordinates; expected equal")
        if bool(self.over) != bool(self.knots):
            raise self._error("a curve has knots and a variable that it is over; expected both or neither")
        if any(before >= after for before, after in itertools.pairwise(self.knots)):
            raise self._error("knots out of order; expected each to be greater than the one before")
        if self.period and self.knots and self.knots[-1] - self.knots[0] >= self.period:
            raise self._error(f"knots reach over more than a period; expected less than {self.period:g}")

    @property
    def unit(self) -> str:
        """Unit of f."""
        return law_quantities(self.component)[self.acts_on]

    def acts_at(self) -> Stage:
        """Return the stage of the quantity."""
        return STAGE_OF.get(self.acts_on, "body")

    def act(self, block: Block, state: MotionState | None = None) -> tuple[Block, Any]:
        """Change the quantity by the law; the state is the start and the distance rolled since then.

        Raises:
            EffectError: The robot does not have a variable, or the law is not finite at some step.
        """
        motion = Motion(block, self.component, state)
        value = self.value(motion.values(self._variables()))
        if not np.all(np.isfinite(value)):
            bad = block.time[~np.isfinite(np.broadcast_to(value, len(block)))][0] - motion.begun.start
            raise self._error(f"no finite number {bad:g} s after the start; expected one at every step")
        if self.acts_on == "travel":
            wheel = wheel_number(self.component)
            return block.with_travel(wheel, (1.0 + value) * block.travel[:, wheel]), motion.after()
        if self.acts_on == "reading":
            channel = LINKAGE.index(self.component)
            return block.with_reading(channel, block.reading[:, channel] + value), motion.after()
        truck = truck_number(self.component)
        twist = block.twist[:, truck].copy()
        gone = twist[:, 2] if self.acts_on == "turn" else np.abs(twist[:, 0])
        twist[:, TWIST[self.acts_on]] += value * gone
        return block.with_twist(truck, twist), motion.after()

    def value(self, variables: dict[str, Array]) -> Array:
        """Return f with the shape of the variables; a scalar if it depends on none."""
        value = parse(self.formula).value(variables)
        if self.over:
            period = self.period or None
            value = value + np.interp(variables[self.over], self.knots, self.ordinates, period=period)
        return np.asarray(value)

    def describe(self, vehicle: VehicleParameters) -> str:  # noqa: ARG002
        """Return what the component does by the law, whose variables are in SI units."""
        does = WHAT_IT_DOES[self.acts_on].format(unit=self.unit)
        parts = [self.formula] if self.formula != "0" or not self.over else []
        if self.over:
            points = zip(self.ordinates, self.knots, strict=True)
            curve = ", ".join(f"{ordinate:.3g} at {knot:.3g}" for ordinate, knot in points)
            parts.append(f"a curve over {self.over} ({curve})")
        return f"{component_in_words(self.component)} {does}, f = {' + '.join(parts)} in SI units"

    def _variables(self) -> frozenset[str]:
        return parse(self.formula).variables | ({self.over} if self.over else frozenset())

    def _error(self, problem: str) -> EffectError:
        return EffectError(f"law of {self.component}: {problem}")
