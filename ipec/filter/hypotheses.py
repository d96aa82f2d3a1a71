"""The hypotheses of the filter bank: no error, or an error of one reading beyond a constant bias.

An error whose shape follows from the motion, such as that of an eccentric joint or of a late reading, has an
unknown constant size. Any other error is a first-order Gauss-Markov process over the distance driven, with a
correlation length of one link length, or of one side of the robot's path.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

READINGS = (
    *("joint_a", "joint_b", "link", "wheels of a", "wheels of b"),
    *("a.left", "a.right", "b.left", "b.right"),
)
TRUCKS, ENCODERS = 3, 5  # numbers of the first truck and of the first wheel in `READINGS`
# Forms of an error: Gauss-Markov process (or none); eccentric, in proportion to sine and cosine of the
# joint's angle (of joint_a for the link); eccentric with the zero set while the linkage was straight (for the
# link, whose bias is less well known, both are the same); scale of the link's extension; play; delay, and for
# a wheel also slip in proportion to its acceleration; creep of a truck towards one direction of the floor;
# creep of both trucks because they push each other by the link, a Gauss-Markov process.
WANDERS, OFF_CENTRE, ZEROED, LINK_SCALE, PLAY, LATE, SLOPE, PUSH = range(8)


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """One possible error of a reading, or of a truck's heading by its wheels.

    Attributes:
        reading: Number in `READINGS` of the erroneous reading; -1 for none.
        sizes: Standard deviations of the sizes of the error: [rad] or [m]; of a scale [1]; of a delay
            [periods of SYNC] and of slip [s^2/m]; of creep along x and y [1]; of creep along the link and of
            the trucks' difference in it [1].
        correlation_length: Distance over which the error is correlated [lengths of the link].
        form: Its form.
    """

    reading: int = -1
    sizes: tuple[float, float] = (0.0, 0.0)
    correlation_length: float = math.inf
    form: int = WANDERS


# [rad], [m] Largest standard deviation of a Gauss-Markov error: a loose joint, 0.9 degrees (assumption); 3
# mm, C 6 for its linear encoder. The smaller one is a fifth of it; a 25th of it changes no estimate.
MAX_READING_ERRORS = (math.radians(0.9), math.radians(0.9), 0.003, math.radians(0.9), math.radians(0.9))
# [rad], [m] Eccentricity: a disc of 50 mm off centre by 0.4 mm; a pivot by 10 mm, the error of a tape
# measure.
MAX_ECCENTRICITIES = (math.radians(0.9), math.radians(0.9), 0.01)
# [1] Scale error of a draw-wire's drum; [periods of SYNC] delay of a slow device; [s^2/m] slip of rubber that
# loses a tenth of its travel at 1 m/s^2. Assumptions: the largest that a working robot may have.
MAX_DRUM_ERROR, MAX_DELAY, MAX_SLIP = 0.1, 3.0, 0.1
# [1] Slip of a tyre whose cornering stiffness is six times its load (Pacejka 2012, chapter 1) on a ramp of 6
# %. The linkage shows it only if the tyres of the two trucks differ.
MAX_SLOPE_CREEP = 0.01
# [1] Change of a rolling radius with load or pressure: half of `prior.SUSPECT_SIZES` of a diameter.
MAX_RADIUS_CHANGE = 0.005
# [1] Slip under the friction of a jammed slider, a fifth of a truck's weight, on tyres as above. [1] Two
# trucks whose weights are 2 to 1 creep by a third less and more than their mean.
MAX_PUSH_CREEP, MAX_PUSH_DIFFERENCE = 0.03, 1.0 / 3.0
HYPOTHESES = (
    Hypothesis(),
    *(
        Hypothesis(reading, (MAX_READING_ERRORS[reading] / 5.0**scale, 0.0), alike)
        for reading, scale, alike in itertools.product(range(ENCODERS), range(2), (1.0, 4.0))
    ),
    *(
        Hypothesis(reading, (MAX_ECCENTRICITIES[reading], MAX_ECCENTRICITIES[reading]), form=OFF_CENTRE)
        for reading in range(TRUCKS)
    ),
    *(
        Hypothesis(joint, (MAX_ECCENTRICITIES[joint], MAX_ECCENTRICITIES[joint]), form=ZEROED)
        for joint in (0, 1)
    ),
    Hypothesis(2, (MAX_DRUM_ERROR, 0.0), form=LINK_SCALE),
    *(Hypothesis(joint, (MAX_READING_ERRORS[joint], 0.0), form=PLAY) for joint in (0, 1)),
    *(Hypothesis(joint, (MAX_DELAY, 0.0), form=LATE) for joint in (0, 1)),
    # Both wheels of a truck (one node, one drive), or one of them.
    *(Hypothesis(wheels, (MAX_DELAY, MAX_SLIP), form=LATE) for wheels in range(TRUCKS, len(READINGS))),
    *(Hypothesis(wheel, (MAX_RADIUS_CHANGE, 0.0), 4.0) for wheel in range(ENCODERS, len(READINGS))),
    *(Hypothesis(truck, (MAX_SLOPE_CREEP, MAX_SLOPE_CREEP), form=SLOPE) for truck in range(TRUCKS, ENCODERS)),
    *(Hypothesis(2, (MAX_PUSH_CREEP / 5.0**scale, MAX_PUSH_DIFFERENCE), 1.0, PUSH) for scale in range(2)),
)
"""No error, or one erroneous reading. Correlation lengths of 1 and 4 link lengths: a motion of the
linkage, and to a side of the papers' squares and laps."""


def log_prior_probabilities(wrong: float) -> list[float]:
    """Return the log prior probability of every hypothesis.

    Args:
        wrong: Probability that a given reading is erroneous; its forms are equally probable.
    """
    log_correct = math.log(1.0 - wrong)
    log_single = math.log(wrong) + (len(READINGS) - 1) * log_correct
    kinds = [(hypothesis.reading, hypothesis.form) for hypothesis in HYPOTHESES[1:]]
    log_second = math.log(wrong)  # creep shows only if the floor slopes and the tyres differ: two conditions
    forms = [len({form for reading, form in kinds if reading == number}) for number in range(len(READINGS))]
    log_priors = [
        log_single - math.log(forms[kind[0]] * kinds.count(kind)) + (log_second if kind[1] == SLOPE else 0.0)
        for kind in kinds
    ]
    return [len(READINGS) * log_correct, *log_priors]
