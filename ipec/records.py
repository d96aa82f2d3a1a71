"""The records that the correctors' compiled functions share: fixed settings, and what changes per sample."""

from typing import Annotated

from ipec.readings import Reading, Scales
from vehicle.compiled import Array

PLAIN, CLAPPER, OMNIMATE = range(3)


class Settings(Scales):
    """What does not change during a drive.

    Attributes:
        law: PLAIN, CLAPPER or OMNIMATE.
        tolerance: of each joint: half of what it resolves, and what the wheels resolve of the heading [rad];
            0 where the print is followed.
        as_printed: 1 for C (14)-(15) as printed.
        previous_b: 1 for O (1) as printed.
        printed_sign: 1 for O (2)-(4) as printed.
    """

    law: int
    tolerance: Annotated[Array, 2]
    as_printed: int
    previous_b: int
    printed_sign: int


class State(Reading):
    """The last sample, and the poses after it.

    Attributes:
        placed: 1 since truck b's place behind truck a has been read from the linkage.
        pose: of both trucks.
        previous_b: pose of truck b before this sample.
        correction: of both headings in this sample [rad].
        taken_back: travel of truck a taken back in this sample [m].
    """

    placed: int
    pose: Annotated[Array, (2, 3)]
    previous_b: Annotated[Array, 3]
    correction: Annotated[Array, 2]
    taken_back: float
