"""Wheel eccentricity: the rolling radius varies once per turn of the wheel.

The tyre is out of round, or the bore of the axle is off its centre. The rolling radius is R + amplitude
cos(angle + phase), with the wheel's angle as it is counted from the encoder's zero.

It is seen as a wave in the heading and in the link's readings, once per turn of that wheel and zero on
average.

It is confused with a gear harmonic of order 1, whose wave has the same period.

The source is the geometry of an eccentric circle that rolls on a plane, to first order in amplitude / R.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from omnimate.effects.block import Block, wheel_number
from omnimate.effects.effect import FAULT, WHEEL, Effect, Parameter, Prior

if TYPE_CHECKING:
    from omnimate.effects.effect import Abscissa, Stage, Startup


@dataclass(frozen=True, slots=True)
class WheelEccentricity(Effect):
    """The rolling radius is R + amplitude cos(angle + phase).

    Attributes:
        amplitude: Amplitude of the rolling radius [m].
        phase: Phase of the wave at the encoder's zero [rad].
    """

    amplitude: float = 0.0
    phase: float = 0.0

    name: ClassVar[str] = "wheel_eccentricity"
    stage: ClassVar[Stage] = "travel"
    components: ClassVar[tuple[str, ...]] = WHEEL
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("amplitude", "m", null=0.0, scale=3e-4, low=0.0, high=0.02),
        Parameter("phase", "rad", null=None, scale=2.0, low=-7.0, high=7.0),
    )
    prior: ClassVar[Prior] = Prior(FAULT)
    regime: ClassVar[str] = "wheel angle of {component}"
    separating_drive: ClassVar[str] = "a slow straight of twenty wheel turns"
    says: ClassVar[str] = (
        "{part} runs out of round by {amplitude:.3f} mm: once per turn of that wheel the truck yaws."
    )
    plotted_over: ClassVar[Abscissa] = "wheel angle"
    startup_nuisance: ClassVar[Startup | None] = "always"

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Add the integral of the changed radius over the step."""
        wheel = wheel_number(self.component)
        end = block.angle[:, wheel]
        begin = end - block.turned[:, wheel]
        gained = self.amplitude * (np.sin(end + self.phase) - np.sin(begin + self.phase))
        return block.with_travel(wheel, block.travel[:, wheel] + gained), state
