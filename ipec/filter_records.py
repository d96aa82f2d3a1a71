"""The records that the filter's and the smoother's compiled functions share, and the order of its states.

The states are where truck a is, where the link points, what the linkage truly measures, and what makes
the encoders err. Joint angles and link length do not depend on where the robot is, so that what the
linkage says can never pretend to say where the robot is.
"""

from typing import Annotated

from ipec.readings import Reading, Scales
from vehicle.compiled import Array, IntArray

X, Y, LINK, JOINT_A, JOINT_B, LENGTH = range(6)  # place of a [m], heading of the link [rad], linkage
WHEEL, WHEELBASE, JOINT_BIAS, LENGTH_BIAS = 6, 10, 12, 14  # the first of each kind
POSE, STATES = 6, 15
INPUTS = 6  # travel of the four wheels, sideways slip of the two trucks


class FilterSettings(Scales):
    """What does not change during a drive.

    Attributes:
        roughness: variance of a wheel's travel per metre [m].
        sideways: variance of a truck's sideways slip per metre [m].
        resolution: what each wheel resolves, as variance of the travel in a sample [m^2].
        half: half a count of joint_a, joint_b and link [rad, rad, m].
        blur: variance of these readings beside their resolution [rad^2, rad^2, m^2].
        drift: variance per metre that each wheel's and wheelbase's factor gains.
        gate: of the disturbance test, squared standard deviations.
        hold: way for which a disturbed wheel stays distrusted [m].
        distrust: standard deviation of a disturbed wheel's travel, as part of what it rolled.
    """

    roughness: float
    sideways: float
    resolution: Annotated[Array, 4]
    half: Annotated[Array, 3]
    blur: Annotated[Array, 3]
    drift: float
    gate: float
    hold: float
    distrust: float


class FilterState(Reading):
    """The estimate after a sample, and the step that led to it.

    Attributes:
        placed: 1 since the linkage has been read.
        predicted: 1 where this sample moved the estimate.
        mean: `(15,)`, see the constants above: reading = true + bias, travel = rolled x (1 + factor).
        covariance: `(15, 15)` of its error.
        alert: way for which each wheel stays distrusted [m].
        lost: travel that each distrusted wheel lost in this sample [m].
        nis: normalised innovation squared of this sample, 3 degrees of freedom; nan without one.
        transition: derivative of the first six states by the states before.
        inputs: derivative of the first six states by the inputs.
        input_variance: of the inputs in this sample.
        updated: 1 for joint_a, joint_b, link where the reading said something new.
        gain: of each update: covariance with the reading `(15,)`, innovation and information.
    """

    placed: int
    predicted: int
    mean: Annotated[Array, 15]
    covariance: Annotated[Array, (15, 15)]
    alert: Annotated[Array, 4]
    lost: Annotated[Array, 4]
    nis: float
    transition: Annotated[Array, (6, 15)]
    inputs: Annotated[Array, (6, 6)]
    input_variance: Annotated[Array, 6]
    updated: Annotated[IntArray, 3]
    gain: Annotated[Array, (3, 17)]
