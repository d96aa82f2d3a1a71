"""The records that the filter's and the smoother's compiled functions share, and the order of its states.

The states are the place of truck a, the heading of the link, the true joint angles and link length, and
what makes the encoders err. Joint angles and link length do not depend on the place of the robot, so that a
reading of the linkage cannot add false information about that place.
"""

from typing import Annotated

from omnimate.ipec.filter.hypotheses import HYPOTHESES
from omnimate.ipec.readings import Reading, Scales
from omnimate.vehicle.compiled import Array, IntArray

X, Y, LINK, JOINT_A, JOINT_B, LENGTH = range(6)  # place of a [m], heading of the link [rad], linkage
POSE = 6  # states above
WANDER = 6  # what a reading, or a heading by wheels, errs by under a hypothesis: the first of `ERRORS` sizes
ERRORS = 2
FAST = 8  # pose and errors
WHEEL, WHEELBASE, CREEP, JOINT_BIAS, LENGTH_BIAS = 8, 12, 14, 16, 18  # the first of each kind
STATES = 19
SLOW = STATES - FAST  # what makes the encoders err
INPUTS = 8  # travel of the four wheels, sideways slip of the two trucks, their slip ahead
SIDES, AHEAD = 4, 6  # the first of each kind
BANK = len(HYPOTHESES)  # filters that run side by side, one for each hypothesis
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
        credit: Logarithm of the probability of each hypothesis before the drive, shape `(H,)`.
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
    credit: Annotated[Array, BANK]
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


class Step:
    """What the smoother needs of a step under one hypothesis; fields of `FilterState` and `OpenFilter`.

    Attributes:
        predicted: 1 where a step was finished; 0 for a first reading or a fix.
        mean: Estimate of the first six states, shape `(6,)`.
        offset: What the open filter would add to them, shape `(6,)`.
        covariance: Covariance of the open filter, shape `(19, 19)`.
        shift: How far the first six states moved to the mixture, shape `(6,)`.
        way: Travel of the wheels [m], shape `(4,)`.
        lasting: Share of the error that outlasts the step.
        reading: What errs, a number in `hypotheses.READINGS`; -1 for nothing.
        row: Derivative of the mean readings by the states after the step, shape `(3, 19)`.
        transition: Derivative of the first six states by the states before the step, shape `(6, 19)`.
        inputs: Derivative of the first six states by the inputs, shape `(6, 8)`.
        input_variance: Variance of the inputs [m^2], shape `(8,)`.
        updated: 1 for joint_a, joint_b, link where the reading said something new, shape `(3,)`.
        gain: Covariance of the states with each reading, push and information, shape `(3, 21)`.
    """

    predicted: int
    mean: Annotated[Array, 6]
    offset: Annotated[Array, 6]
    covariance: Annotated[Array, (19, 19)]
    shift: Annotated[Array, 6]
    way: Annotated[Array, 4]
    lasting: float
    reading: int
    row: Annotated[Array, (3, 19)]
    transition: Annotated[Array, (6, 19)]
    inputs: Annotated[Array, (6, 8)]
    input_variance: Annotated[Array, 8]
    updated: Annotated[IntArray, 3]
    gain: Annotated[Array, (3, 21)]


class FilterState(Reading):
    """The estimate after a sample, and the step that led to it.

    Attributes:
        placed: 1 since the linkage has been read.
        predicted: 1 where this sample finished a step.
        mean: Estimate of the states, shape `(19,)`: reading = true + wander + bias,
            travel = rolled x (1 + factor). What wanders has no mean of all hypotheses; it is 0 here.
        known: Covariance of the estimate's error, shape `(19, 19)`.
        score: Logarithm of the probability density of what was read, under each hypothesis, shape `(H,)`.
        weight: Probability of each hypothesis, shape `(H,)`.
        repeated: 1 where a part of a drive runs again, with the mixture of then.
        decided: How many times the mixture was decided.
        bumpy: 1 while a wheel is distrusted.
        move: Step from the estimate to the last mixture, shape `(19,)`.
        origin: Place of truck a at the start [m], shape `(2,)`.
        fixed: 1 since an absolute pose was taken.
        turned: Variance of the angle between body and wheels of truck a [rad^2].
        suspicion: Probability that each suspect is at work, shape `(15,)`.
        shift: How far the first six states moved to the mixture after this sample, shape `(6,)`.
        begun: Heading of the link, joint angles and length at the start of the step, shape `(4,)`.
        way: Travel of the wheels since the start of the step [m], shape `(4,)`.
        went: Travel of the wheels in the step that was finished last [m], shape `(4,)`.
        speed: Mean speed of the wheels in the step that was finished last [m/s], shape `(4,)`.
        speed_before: The same of the step before it [m/s], shape `(4,)`.
        rate: Mean rate of the two joints in the step that was finished last [rad/s], shape `(2,)`.
        rate_before: The same of the step before it [rad/s], shape `(2,)`.
        rolled: What `way` would be without signs, shape `(4,)`.
        samples: Samples since then.
        seen: Samples since then in which the linkage was read.
        missed: Sum of reading minus prediction in them, shape `(3,)`.
        late: Reading minus prediction in the last of them, shape `(3,)`.
        jump: Its change from the sample before, shape `(3,)`.
        jumps: Sum of squared changes since the start of the step, shape `(3,)`.
        blur: Variance of the readings from sample to sample, as learned [rad^2, rad^2, m^2], shape `(3,)`.
        scatter: Variance of the mean readings of this step [rad^2, rad^2, m^2], shape `(3,)`.
        sure: Half the steps that they are still sure within [rad, rad, m], shape `(3,)`.
        transition: Derivative of the first six states by the states before the step, shape `(6, 19)`.
        inputs: Derivative of the first six states by the inputs, shape `(6, 8)`.
        levels: Variance per metre of wheels of a, of b, sides and slack [m], shape `(4,)`; this and what
            follows is working memory for one open filter after the other.
        carried: Product of transition and covariance, shape `(6, 19)`.
        shares: Covariance of each wheel's lost travel with the states, shape `(4, 19)`.
        spread: Covariance of the innovations, shape `(3, 3)`.
        information: Its inverse, shape `(3, 3)`.
        pull: Product of the information and the innovations, shape `(3,)`.
        innovations: Mean readings minus what is predicted, shape `(3,)`.
        explained: What each input explains of the squared innovation, shape `(8,)`.
    """

    placed: int
    predicted: int
    mean: Annotated[Array, 19]
    known: Annotated[Array, (19, 19)]
    score: Annotated[Array, BANK]
    weight: Annotated[Array, BANK]
    repeated: int
    decided: int
    bumpy: int
    move: Annotated[Array, 19]
    origin: Annotated[Array, 2]
    fixed: int
    turned: float
    suspicion: Annotated[Array, 15]
    shift: Annotated[Array, 6]
    begun: Annotated[Array, 4]
    way: Annotated[Array, 4]
    went: Annotated[Array, 4]
    speed: Annotated[Array, 4]
    speed_before: Annotated[Array, 4]
    rate: Annotated[Array, 2]
    rate_before: Annotated[Array, 2]
    rolled: Annotated[Array, 4]
    samples: int
    seen: int
    missed: Annotated[Array, 3]
    late: Annotated[Array, 3]
    jump: Annotated[Array, 3]
    jumps: Annotated[Array, 3]
    blur: Annotated[Array, 3]
    scatter: Annotated[Array, 3]
    sure: Annotated[Array, 3]
    transition: Annotated[Array, (6, 19)]
    inputs: Annotated[Array, (6, 8)]
    levels: Annotated[Array, 4]
    carried: Annotated[Array, (6, 19)]
    shares: Annotated[Array, (4, 19)]
    spread: Annotated[Array, (3, 3)]
    information: Annotated[Array, (3, 3)]
    pull: Annotated[Array, 3]
    innovations: Annotated[Array, 3]
    explained: Annotated[Array, 8]


class OpenFilter:
    """The open filter under one hypothesis. It changes where a step ends or a fix is taken, and else not.

    Attributes:
        number: Number of the hypothesis.
        reading: What errs, a number in `hypotheses.READINGS`; -1 for nothing.
        form: Form of the error, see `omnimate.ipec.filter.hypotheses`.
        variance: Variance of the sizes of what it errs by, in the units of its form, shape `(2,)`.
        alike: Way over which it errs alike [m].
        touched: Side of its play to which a joint has moved, from -1 to 1, see `omnimate.ipec.filter.forms`.
        side: The same in the mean of this step.
        vague: Variance that the reading has more in this step, because its form is not known so well [rad^2].
        share: By what joint_a, joint_b and link change per unit of each size in this step, shape `(2, 3)`.
        gained: By what each input changes per unit of each size in this step, shape `(8, 2)`.
        followed: 1 where the hypothesis is carried on; 0 for most where a drive runs again.
        offset: What it would add to the mean, shape `(19,)`.
        row: Derivative of the mean readings by the states after the step, shape `(3, 19)`.
        covariance: Its covariance, shape `(19, 19)`.
        learned: Sums from which the noise is learned: variance x way, way; shape `(4, 2)`.
        alert: Travel for which each input stays distrusted [m], shape `(8,)`.
        lost: Travel that each distrusted wheel lost in the last step [m], shape `(4,)`.
        nis: Normalised innovation squared of the last step, 3 degrees of freedom; nan without one.
        lasting: Share of the error that outlasts this step.
        input_variance: Variance of the inputs in this step [m^2], shape `(8,)`.
        updated: 1 for joint_a, joint_b, link where the reading said something new, shape `(3,)`.
        gain: Covariance of the states with each reading `(19,)`, then the push and the information of `cut`,
            shape `(3, 21)`.
    """

    number: int
    reading: int
    form: int
    variance: Annotated[Array, 2]
    alike: float
    touched: float
    side: float
    vague: float
    share: Annotated[Array, (2, 3)]
    gained: Annotated[Array, (8, 2)]
    followed: int
    offset: Annotated[Array, 19]
    row: Annotated[Array, (3, 19)]
    covariance: Annotated[Array, (19, 19)]
    learned: Annotated[Array, (4, 2)]
    alert: Annotated[Array, 8]
    lost: Annotated[Array, 4]
    nis: float
    lasting: float
    input_variance: Annotated[Array, 8]
    updated: Annotated[IntArray, 3]
    gain: Annotated[Array, (3, 21)]
