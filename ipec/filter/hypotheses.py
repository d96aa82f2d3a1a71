"""What else may be at work than a floor: the hypotheses under which the filter runs, side by side.

An encoder may read what is neither its angle nor a constant bias. Where the error has a form that the motion
gives, such as that of a joint off its centre or of a reading that is late, its size alone is unknown, and
stays. Else it wanders: it stays alike while the linkage moves as much as a way of its own length moves it, or
as long as a side of the robot's path lasts.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

READINGS = (
    *("joint_a", "joint_b", "link", "wheels of a", "wheels of b"),
    *("a.left", "a.right", "b.left", "b.right"),
)
TRUCKS, ENCODERS = 3, 5  # the first truck and the first single wheel in `READINGS`
# The forms of an error: none; off the centre, in proportion to the sine and the cosine of the joint's angle
# (of joint_a for the link), the same with a zero set while the linkage was straight (the link's bias, which
# is not known as well as a joint's, makes both the same); in proportion to what the link is longer than at
# rest; play; late, or for a wheel also slip in proportion to its acceleration; creep of a truck towards one
# direction of the floor; creep of both trucks that push each other by the link, which wanders.
WANDERS, OFF_CENTRE, ZEROED, STRETCH, PLAY, LATE, SLOPE, PUSH = range(8)


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """What a reading, or a truck's heading by its wheels, may do.

    Attributes:
        reading: Number in `READINGS` of what errs; -1 for nothing.
        sizes: Standard deviations of the sizes of the error: [rad] or [m]; of a stretch [1]; of a delay
            [periods of SYNC] and of slip [s^2/m]; of creep along x and y [1]; of creep along the link and of
            the trucks' difference in it [1].
        alike: Way over which that error stays alike [lengths of the link].
        form: Its form.
    """

    reading: int = -1
    sizes: tuple[float, float] = (0.0, 0.0)
    alike: float = math.inf
    form: int = WANDERS


# Largest error of each: a loose joint, 0.9 degrees; 3 mm, C 6 states of its linear encoder. The smallest is a
# 25th of it, a tenth of what a rotary encoder of 1024 steps resolves; what is smaller is lost in the floor.
LARGEST = (math.radians(0.9), math.radians(0.9), 0.003, math.radians(0.9), math.radians(0.9))
# Off the centre: a disc of 50 mm by 0.4 mm; a pivot by 10 mm, as the link's length by a tape.
OFF = (math.radians(0.9), math.radians(0.9), 0.01)
# The drum of a draw-wire. A device that answers three periods of SYNC late. Rubber that slips a tenth of the
# way at 1 m/s^2.
DRUM, DELAY, SLIP = 0.1, 3.0, 0.1
# A tyre whose cornering stiffness is six times its load (Pacejka 2012, chapter 1) on a ramp of 6 %. Encoders
# see it where the tyres of one truck yield and those of the other do not.
CREEP = 0.01
# A tyre whose load or air changes: half of what a tyre and its load are expected to differ by.
CHANGES = 0.005
# A slider that jams or has friction, by a fifth of a truck's weight, on the same tyres. Two trucks that weigh
# 2 to 1 creep by a third of the mean less and more.
PUSHED, UNLIKE = 0.03, 1.0 / 3.0
HYPOTHESES = (
    Hypothesis(),
    *(
        Hypothesis(reading, (LARGEST[reading] / 5.0**scale, 0.0), alike)
        for reading, scale, alike in itertools.product(range(ENCODERS), range(3), (1.0, 4.0))
    ),
    *(Hypothesis(reading, (OFF[reading], OFF[reading]), form=OFF_CENTRE) for reading in range(TRUCKS)),
    *(Hypothesis(joint, (OFF[joint], OFF[joint]), form=ZEROED) for joint in (0, 1)),
    Hypothesis(2, (DRUM, 0.0), form=STRETCH),
    *(Hypothesis(joint, (LARGEST[joint], 0.0), form=PLAY) for joint in (0, 1)),
    *(Hypothesis(joint, (DELAY, 0.0), form=LATE) for joint in (0, 1)),
    # A truck's two wheels report together and drive together; or a single one of them errs.
    *(Hypothesis(wheels, (DELAY, SLIP), form=LATE) for wheels in range(TRUCKS, len(READINGS))),
    *(Hypothesis(wheel, (CHANGES, 0.0), 4.0) for wheel in range(ENCODERS, len(READINGS))),
    *(Hypothesis(truck, (CREEP, CREEP), form=SLOPE) for truck in range(TRUCKS, ENCODERS)),
    *(Hypothesis(2, (PUSHED / 5.0**scale, UNLIKE), 1.0, PUSH) for scale in range(3)),
)
"""What is compared: all is well, or one reading errs. Ways of 1 and 4 link lengths are a motion of the
linkage, and a side of the papers' squares and laps."""


def chances_before(wrong: float) -> list[float]:
    """Return the logarithm of each hypothesis' probability before a drive.

    Args:
        wrong: Probability that a given reading errs; its forms are as probable as each other.
    """
    right = math.log(1.0 - wrong)
    alone = math.log(wrong) + (len(READINGS) - 1) * right
    kinds = [(hypothesis.reading, hypothesis.form) for hypothesis in HYPOTHESES[1:]]
    both = math.log(wrong)  # a truck creeps alone where the floor slopes and its tyres are unlike the others
    forms = [len({form for reading, form in kinds if reading == number}) for number in range(len(READINGS))]
    each = [
        alone - math.log(forms[kind[0]] * kinds.count(kind)) + (both if kind[1] == SLOPE else 0.0)
        for kind in kinds
    ]
    return [len(READINGS) * right, *each]
