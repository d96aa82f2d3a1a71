"""Link eccentricity: the error of the link's length depends on a joint's angle.

The link is not hinged at the axis of the joint. The reading is length + amplitude cos(angle of joint_a +
phase).

It is seen in turns with the joints at large angles, as a car drives them.

It is confused with an eccentric encoder of the joint.

The source is the geometry of an offset hinge, to first order.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from omnimate.effects.block import LINKAGE
from omnimate.effects.effect import LINK, RARE, Effect, Parameter, Prior

if TYPE_CHECKING:
    from omnimate.effects.block import Block
    from omnimate.effects.effect import Abscissa, Stage


@dataclass(frozen=True, slots=True)
class LinkEccentricity(Effect):
    """The reading is length + amplitude cos(angle of joint_a + phase).

    Attributes:
        amplitude: Largest error of the reading [m].
        phase: Phase of the error at angle 0 of joint_a [rad].
    """

    amplitude: float = 0.0
    phase: float = 0.0

    name: ClassVar[str] = "link_eccentricity"
    stage: ClassVar[Stage] = "reading"
    components: ClassVar[tuple[str, ...]] = LINK
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("amplitude", "m", null=0.0, scale=0.002, low=0.0, high=1.0),
        Parameter("phase", "rad", null=None, scale=2.0, low=-7.0, high=7.0),
    )
    prior: ClassVar[Prior] = Prior(RARE, largest=5.0)
    regime: ClassVar[str] = "angle of joint_a"
    separating_drive: ClassVar[str] = "car-like turns that take joint_a through a wide range of angles"
    says: ClassVar[str] = "{part} errs by {amplitude:.2f} mm with the angle of joint a."
    plotted_over: ClassVar[Abscissa] = "joint angle"

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Add the error."""
        channel = LINKAGE.index(self.component)
        reading = block.reading[:, channel]
        return block.with_reading(
            channel, reading + self.amplitude * np.cos(block.reading[:, 0] + self.phase)
        ), state
