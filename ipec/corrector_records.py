"""The records that the correctors' compiled functions share: fixed settings, and what changes per sample."""

from typing import Annotated

from omnimate.ipec.readings import Reading, Scales
from omnimate.vehicle.compiled import Array

PLAIN, CLAPPER, OMNIMATE = range(3)


class Settings(Scales):
    """What does not change during a drive.

    Attributes:
        law: Which equations are used: PLAIN, CLAPPER or OMNIMATE.
        tolerance: Error of each truck's heading that is not corrected [rad], shape `(2,)`: half a count of
            the joint plus the resolution of the wheels.
    """

    law: int
    tolerance: Annotated[Array, 2]


class State(Reading):
    """The last sample, and the poses after it.

    Attributes:
        placed: 1 since truck b's place behind truck a has been read from the linkage.
        pose: Poses of truck a and b [m, m, rad], shape `(2, 3)`.
        correction: Correction of both headings in this sample [rad], shape `(2,)`.
        taken_back: Travel of truck a taken back in this sample, C (14) [m].
    """

    placed: int
    pose: Annotated[Array, (2, 3)]
    correction: Annotated[Array, 2]
    taken_back: float
