"""Joint eccentricity: a joint's encoder has an error that repeats once per turn.

The disc of the encoder is mounted off its centre. The reading is angle + amplitude cos(angle + phase).

It is seen as a bias that changes with the joint's angle.

It is confused with a constant bias where the joint hardly moves.

The source is the eccentricity of graduated circles.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from omnimate.effects.block import LINKAGE
from omnimate.effects.effect import FAULT, JOINT, Effect, Parameter, Prior

if TYPE_CHECKING:
    from omnimate.effects.block import Block
    from omnimate.effects.effect import Abscissa, Stage


@dataclass(frozen=True, slots=True)
class JointEccentricity(Effect):
    """The reading is angle + amplitude cos(angle + phase).

    Attributes:
        amplitude: Largest error of the reading [rad].
        phase: Phase of the error at angle 0 [rad].
    """

    amplitude: float = 0.0
    phase: float = 0.0

    name: ClassVar[str] = "joint_eccentricity"
    stage: ClassVar[Stage] = "reading"
    components: ClassVar[tuple[str, ...]] = JOINT
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("amplitude", "rad", null=0.0, scale=0.005, low=0.0, high=1.0),
        Parameter("phase", "rad", null=None, scale=2.0, low=-7.0, high=7.0),
    )
    prior: ClassVar[Prior] = Prior(FAULT, largest=6.0)
    regime: ClassVar[str] = "angle of {component}"
    separating_drive: ClassVar[str] = "car-like turns that take the joint through a wide range of angles"
    says: ClassVar[str] = (
        "{part} errs by {amplitude:.3f} degrees once per turn of the joint: its disc is mounted off centre."
    )
    plotted_over: ClassVar[Abscissa] = "joint angle"

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Add the error."""
        channel = LINKAGE.index(self.component)
        reading = block.reading[:, channel]
        return block.with_reading(channel, reading + self.amplitude * np.cos(reading + self.phase)), state
