"""The records that the filter's and the smoother's compiled functions share, and the order of its states.

The states are the place of truck a, the heading of the link, the true joint angles and link length, and
what makes the encoders err. Joint angles and link length do not depend on the place of the robot, so that a
reading of the linkage cannot add false information about that place.
"""

from typing import Annotated

from omnimate.ipec.readings import Reading, Scales
from omnimate.vehicle.compiled import Array, IntArray

X, Y, LINK, JOINT_A, JOINT_B, LENGTH = range(6)  # place of a [m], heading of the link [rad], linkage
WHEEL, WHEELBASE, CREEP, JOINT_BIAS, LENGTH_BIAS = 6, 10, 12, 14, 16  # the first of each kind
POSE, STATES = 6, 17
SLOW = STATES - POSE  # what makes the encoders err
INPUTS = 8  # travel of the four wheels, sideways slip of the two trucks, their slip ahead
SUSPECTS = 15  # ways in which the robot may differ from its description


class FilterSettings(Scales):
    """What does not change during a drive.

    Attributes:
        period: Time between two samples [s].
        noise: Variance per metre that inputs are expected to have: wheels of a, of b, sideways, slack [m].
        trust: Way for which these expectations count [m].
        memory: Way after which what was learned of noise has faded [m].
        resolution: Variance of each wheel's travel in a step from its resolution [m^2].
        half: Half a count of joint_a, joint_b and link [rad, rad, m].
        drift: Variance per metre that the factor of each wheel and wheelbase gains [1/m].
        gate: Limit of the test for disturbed wheels [squared standard deviations].
        hold: Travel for which a disturbed wheel stays distrusted [m].
        distrust: Standard deviation of a distrusted wheel's travel, as a fraction of what it rolled.
        open: Variance of the slow states with which the open filter begins: it excludes nothing, `(11,)`.
        usual: Inverse covariance of the slow states of a robot that is as described, shape `(11, 11)`.
        suspect: Direction of each suspect in the slow states, shape `(15, 11)`.
        size: Standard deviation of each suspect along its direction.
        odds: Logarithm of the odds that a suspect is at work.
        independent: Share of what a step tells that the steps beside it have not told.
    """

    period: float
    noise: Annotated[Array, 4]
    trust: float
    memory: float
    resolution: Annotated[Array, 4]
    half: Annotated[Array, 3]
    drift: float
    gate: float
    hold: float
    distrust: float
    open: Annotated[Array, 11]
    usual: Annotated[Array, (11, 11)]
    suspect: Annotated[Array, (15, 11)]
    size: Annotated[Array, 15]
    odds: Annotated[Array, 15]
    independent: float


class FilterState(Reading):
    """The estimate after a sample, and the step that led to it.

    Attributes:
        placed: 1 since the linkage has been read.
        predicted: 1 where this sample closed a step.
        mean: Estimate of the states, shape `(17,)`: reading = true + bias, travel = rolled x (1 + factor).
        known: Covariance of the estimate's error, shape `(17, 17)`.
        offset: What the open filter would add to `mean`, shape `(17,)`.
        covariance: Covariance of the open filter, shape `(17, 17)`.
        suspicion: Probability that each suspect is at work, shape `(15,)`.
        shift: How far the first six states moved to what is believed after this sample, shape `(6,)`.
        begun: Heading of the link, joint angles and length at the start of the step, shape `(4,)`.
        way: Travel of the wheels since the start of the step [m], shape `(4,)`.
        rolled: The same without its sign, shape `(4,)`.
        samples: Samples since then.
        seen: Samples since then in which the linkage was read.
        missed: Sum of reading minus prediction in them, shape `(3,)`.
        late: Reading minus prediction in the last of them, shape `(3,)`.
        jump: Its change from the sample before, shape `(3,)`.
        jumps: Sum of squared changes since the start of the step, shape `(3,)`.
        blur: Variance of the readings from sample to sample, as learned [rad^2, rad^2, m^2], shape `(3,)`.
        learned: Sums from which the noise is learned: variance x way, way; shape `(4, 2)`.
        alert: Travel for which each input stays distrusted [m], shape `(8,)`.
        lost: Travel that each distrusted wheel lost in this sample [m], shape `(4,)`.
        nis: Normalised innovation squared of this step, 3 degrees of freedom; nan without one.
        transition: Derivative of the first six states by the states before the step, shape `(6, 17)`.
        inputs: Derivative of the first six states by the inputs, shape `(6, 8)`.
        input_variance: Variance of the inputs in this step [m^2], shape `(8,)`.
        updated: 1 for joint_a, joint_b, link where the reading said something new, shape `(3,)`.
        gain: Covariance of the states with each reading `(17,)`, then the push and the information of `cut`,
            shape `(3, 19)`.
    """

    placed: int
    predicted: int
    mean: Annotated[Array, 17]
    known: Annotated[Array, (17, 17)]
    offset: Annotated[Array, 17]
    covariance: Annotated[Array, (17, 17)]
    suspicion: Annotated[Array, 15]
    shift: Annotated[Array, 6]
    begun: Annotated[Array, 4]
    way: Annotated[Array, 4]
    rolled: Annotated[Array, 4]
    samples: int
    seen: int
    missed: Annotated[Array, 3]
    late: Annotated[Array, 3]
    jump: Annotated[Array, 3]
    jumps: Annotated[Array, 3]
    blur: Annotated[Array, 3]
    learned: Annotated[Array, (4, 2)]
    alert: Annotated[Array, 8]
    lost: Annotated[Array, 4]
    nis: float
    transition: Annotated[Array, (6, 17)]
    inputs: Annotated[Array, (6, 8)]
    input_variance: Annotated[Array, 8]
    updated: Annotated[IntArray, 3]
    gain: Annotated[Array, (3, 19)]
