"""Gear backlash: the wheel stands still through the play when its motor reverses.

The encoder sits on the motor's side of a gear that has play.

It is seen as travel that is lost at each reversal of the motor, and nowhere else.

It is confused with the kick of a castor.

The source is the play operator (Visintin, Differential Models of Hysteresis, 1994).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from omnimate.effects.block import wheel_number
from omnimate.effects.effect import FAULT, WHEEL, Block, Effect, Parameter, Prior, VehicleParameters
from omnimate.effects.play import play_output

# [rad] Play of a small gear's output: 0.15 to 0.5 degrees for a low-backlash gear (maxon GP 32 BZ), about one
# degree for others. Play of one wheel beyond that is a fault.
TYPICAL_GEAR_PLAY = math.radians(1.0)


@dataclass(frozen=True, slots=True)
class GearBacklash(Effect):
    """The wheel follows its motor through a play."""

    width: float = 0.0  # width of the whole play, as travel of the wheel [m]

    name = "gear_backlash"
    stage = "travel"
    components = WHEEL
    parameters = (Parameter("width", "m", null=0.0, scale=5e-4, low=0.0, high=0.1),)
    prior = Prior(FAULT, discrepancy=0.3)
    regime = "at reversals of {component}"
    separating_drive = "ten reversals on one straight"
    says = "{part} stands still through a play of {width:.2f} mm each time its motor reverses."
    sizes = (1.0, 6.0)

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Pass the travel through the play; the state is the positions of motor and wheel."""
        wheel = wheel_number(self.component)
        travel = block.travel[:, wheel]
        motor, output = (0.0, None) if state is None else state
        if output is None:  # until it moves for the first time
            moved = travel[np.flatnonzero(travel)[:1]]
            if not len(moved):
                return block, (motor, None)
            output = -0.5 * self.width * float(np.sign(moved[0]))
        rolled = motor + np.cumsum(travel)
        wheels = play_output(rolled, output, self.width)
        state = float(rolled[-1]), float(wheels[-1])
        return block.with_travel(wheel, np.diff(wheels, prepend=output)), state

    @classmethod
    def in_any_robot(cls, component: str, vehicle: VehicleParameters) -> GearBacklash:
        """Return half the play of a typical gear, a nuisance of every wheel."""
        diameter = vehicle.wheel_diameter(component)  # type: ignore[arg-type]
        return cls(component=component, width=0.5 * TYPICAL_GEAR_PLAY * diameter)
