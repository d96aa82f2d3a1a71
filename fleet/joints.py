"""What the linkage of a two-truck robot says of its joints in one recording, by the filter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.ipec.filter.estimate import estimate
from omnimate.ipec.filter.prior import WATCHED

if TYPE_CHECKING:
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array

JOINT_NUMBERS = ("joint_a", "joint_b")  # bias of each joint's encoder [rad]
_PLACE = slice(8, 10)  # of both in `SlowParameters.sigma`


@dataclass(frozen=True, slots=True)
class Joints:
    """Biases of the joints' encoders.

    Attributes:
        bias: Of joint_a and joint_b [rad], `(2,)`; `(0,)` for a robot without a linkage.
        sigma: Standard deviations [rad], likewise.
    """

    bias: Array
    sigma: Array


NO_JOINTS = Joints(np.zeros(0), np.zeros(0))


def joints_of(recording: Recording) -> Joints:
    """Return the biases that the filter learns; nothing for a robot without a linkage.

    Raises:
        LinkageChannelError: A channel of the linkage was never read, or was frozen.
    """
    if recording.vehicle.linkage is None:
        return NO_JOINTS
    slow = estimate(recording, prior=WATCHED).slow
    return Joints(np.array(slow.joint_bias), np.array(slow.sigma[_PLACE]))
