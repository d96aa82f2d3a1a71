"""The records that the filter's and the smoother's compiled functions share, and the order of its states.

The states are the place of truck a, the heading of the link, the true joint angles and link length, and
what makes the encoders err. Joint angles and link length do not depend on the place of the robot, so that a
reading of the linkage cannot add false information about that place.
"""

from typing import Annotated

from omnimate.ipec.readings import Reading, Scales
from omnimate.vehicle.compiled import Array, IntArray

X, Y, LINK, JOINT_A, JOINT_B, LENGTH = range(6)  # place of a [m], heading of the link [rad], linkage
WHEEL, WHEELBASE, JOINT_BIAS, LENGTH_BIAS = 6, 10, 12, 14  # the first of each kind
POSE, STATES = 6, 15
INPUTS = 6  # travel of the four wheels, sideways slip of the two trucks


class FilterSettings(Scales):
    """What does not change during a drive.

    Attributes:
        roughness: Variance of a wheel's travel per metre [m].
        sideways: Variance of a truck's sideways slip per metre [m].
        resolution: Variance of each wheel's travel in a sample from its resolution [m^2].
        half: Half a count of joint_a, joint_b and link [rad, rad, m].
        blur: Variance of these readings in addition to their resolution [rad^2, rad^2, m^2].
        drift: Variance per metre that the factor of each wheel and wheelbase gains [1/m].
        gate: Limit of the test for disturbed wheels [squared standard deviations].
        hold: Travel for which a disturbed wheel stays distrusted [m].
        distrust: Standard deviation of a distrusted wheel's travel, as a fraction of what it rolled.
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
        mean: Mean of the states, shape `(15,)`: reading = true + bias, travel = rolled x (1 + factor).
        covariance: Covariance of the mean's error, shape `(15, 15)`.
        alert: Travel for which each wheel stays distrusted [m], shape `(4,)`.
        lost: Travel that each distrusted wheel lost in this sample [m], shape `(4,)`.
        nis: Normalised innovation squared of this sample, 3 degrees of freedom; nan without one.
        transition: Derivative of the first six states by the states before, shape `(6, 15)`.
        inputs: Derivative of the first six states by the inputs, shape `(6, 6)`.
        input_variance: Variance of the inputs in this sample [m^2], shape `(6,)`.
        updated: 1 for joint_a, joint_b, link where the reading said something new, shape `(3,)`.
        gain: Covariance of the states with each reading `(15,)`, then the push and the information of `cut`,
            shape `(3, 17)`.
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
