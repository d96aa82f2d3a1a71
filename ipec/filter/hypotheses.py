"""The hypotheses of the filter bank: no error, or an error of one reading beyond a constant bias.

An error whose shape follows from the motion, such as that of an eccentric joint or of a late reading, has an
unknown constant size. Any other error is a first-order Gauss-Markov process over the distance driven, with a
correlation length of a side of the robot's path. `python -m studies.estimators.hypotheses` shows what each of
them earns on drives that chose none.
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
# joint's angle (of joint_a for the link); scale of the link's extension; play; delay, and for a wheel also
# slip in proportion to its acceleration; creep of a truck towards one direction of the floor; creep of both
# trucks because they push each other by the link, a Gauss-Markov process.
WANDERS, OFF_CENTRE, LINK_SCALE, PLAY, LATE, SLOPE, PUSH = range(7)


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """One possible error of a reading, or of a truck's heading by its wheels."""

    reading: int = -1  # number in `READINGS` of the erroneous reading; -1 for none
    # Standard deviations of the sizes of the error: [rad] or [m]; of a scale [1]; of a delay [periods of
    # SYNC] and of slip [s^2/m]; of creep along x and y [1]; of creep along the link and of the trucks'
    # difference in it [1]
    sizes: tuple[float, float] = (0.0, 0.0)
    correlation_length: float = math.inf  # distance over which the error is correlated [lengths of the link]
    form: int = WANDERS


# [rad] Standard deviations of a Gauss-Markov error: a loose joint, 0.9 degrees (assumption), and a fifth of
# it; a 25th of it changes no estimate.
MAX_ANGLE_ERROR = math.radians(0.9)
ANGLE_ERRORS = (MAX_ANGLE_ERROR, MAX_ANGLE_ERROR / 5.0)
# [lengths of the link] Correlation length: a side of the papers' squares and laps.
SIDE = 4.0
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
# [1] Slip under the friction of a slider that sticks, 4 % of a truck's weight, on tyres as above. [1] Two
# trucks whose weights are 2 to 1 creep by a third less and more than their mean.
MAX_PUSH_CREEP, MAX_PUSH_DIFFERENCE = 0.006, 1.0 / 3.0
HYPOTHESES = (
    Hypothesis(),
    *(  # of both joints, and of both trucks' headings by their wheels
        Hypothesis(reading, (size, 0.0), SIDE)
        for reading, size in itertools.product((0, 1, 3, 4), ANGLE_ERRORS)
    ),
    *(
        Hypothesis(reading, (MAX_ECCENTRICITIES[reading], MAX_ECCENTRICITIES[reading]), form=OFF_CENTRE)
        for reading in range(TRUCKS)
    ),
    Hypothesis(2, (MAX_DRUM_ERROR, 0.0), form=LINK_SCALE),
    *(Hypothesis(joint, (MAX_ANGLE_ERROR, 0.0), form=PLAY) for joint in (0, 1)),
    *(Hypothesis(joint, (MAX_DELAY, 0.0), form=LATE) for joint in (0, 1)),
    # Both wheels of a truck (one node, one drive), or one of them.
    *(Hypothesis(wheels, (MAX_DELAY, MAX_SLIP), form=LATE) for wheels in range(TRUCKS, len(READINGS))),
    *(Hypothesis(wheel, (MAX_RADIUS_CHANGE, 0.0), SIDE) for wheel in range(ENCODERS, len(READINGS))),
    *(Hypothesis(truck, (MAX_SLOPE_CREEP, MAX_SLOPE_CREEP), form=SLOPE) for truck in range(TRUCKS, ENCODERS)),
    Hypothesis(2, (MAX_PUSH_CREEP, MAX_PUSH_DIFFERENCE), 1.0, PUSH),
)
"""No error, or one erroneous reading."""


def log_prior_probabilities(wrong: float) -> list[float]:
    """Return the log prior probability of every hypothesis.

    A given reading is erroneous with the probability `wrong`; its forms are equally probable.
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
