"""Joint backlash: there is play between a joint and its encoder.

When the joint reverses, the reading stands still until the joint has moved through the play.

It is seen in drives that reverse the joint often.

It is confused with the latency of the joint's encoder.

The source is the play operator (Visintin, Differential Models of Hysteresis, 1994).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from omnimate.effects.block import LINKAGE
from omnimate.effects.effect import FAULT, JOINT, Block, Effect, Parameter, Prior
from omnimate.effects.play import play_output


@dataclass(frozen=True, slots=True)
class JointBacklash(Effect):
    """The reading follows the joint through a play."""

    width: float = 0.0  # width of the whole play [rad]

    name = "joint_backlash"
    stage = "reading"
    components = JOINT
    parameters = (Parameter("width", "rad", null=0.0, scale=0.003, low=0.0, high=1.0),)
    # The largest, 5 degrees of play, is seen by eye.
    prior = Prior(FAULT, discrepancy=0.3, largest=30.0)
    regime = "at reversals of {component}"
    separating_drive = "a slalom that reverses the joint often"
    says = "{part} lags by a play of {width:.3f} degrees when the joint reverses."
    plotted_over = "joint angle"
    sizes = (1.0, 4.0, 10.0)
    excited_by = "channel motion"

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Pass the angle through the play; the state is the last reading."""
        channel = LINKAGE.index(self.component)
        angle = block.reading[:, channel]
        shown = play_output(angle, float(angle[0]) if state is None else state, self.width)
        return block.with_reading(channel, shown), float(shown[-1])
