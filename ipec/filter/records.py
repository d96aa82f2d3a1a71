"""The records that the filter's and the smoother's compiled functions share, and the order of its states.

The states are the position of truck a, the heading of the link, true joint angles and link length, and the
parameters of encoder errors. Joint angles and link length are relative: a reading of the linkage adds no
information on the robot's position.
"""

from typing import Annotated

from omnimate.ipec.filter.hypotheses import HYPOTHESES
from omnimate.ipec.readings import Reading, Scales
from omnimate.vehicle.compiled import Array, IntArray

X, Y, LINK, JOINT_A, JOINT_B, LENGTH = range(6)  # place of a [m], heading of the link [rad], linkage
POSE = 6  # states above
WANDER = 6  # first of the `ERRORS` sizes of a hypothesis' error
ERRORS = 2
FAST = 8  # pose and errors
WHEEL, WHEELBASE, CREEP, JOINT_BIAS, LENGTH_BIAS = 8, 12, 14, 16, 18  # the first of each kind
STATES = 19
SLOW = STATES - FAST  # systematic errors of the encoders
INPUTS = 8  # travel of four wheels, sideways slip of two trucks, their slip ahead
SIDES, AHEAD = 4, 6  # the first of each kind
HYPOTHESIS_COUNT = len(HYPOTHESES)  # filters of the bank, one for every hypothesis
SUSPECT_COUNT = 17  # length of `prior.SUSPECT_NAMES`
VALUE_COUNT = 9  # length of `prior.VALUE_NAMES`


class FilterSettings(Scales):
    """Constants of the filter for one robot.

    Attributes:
        period: Time between two samples [s].
        noise: Initial variance per metre of wheels of a, wheels of b, sideways slip, slack [m].
        trust: Distance that the initial levels count for [m].
        memory: Distance over which learned levels are forgotten [m].
        resolution: Variance of each wheel's travel in a step from its resolution [m^2].
        half_count: Half a count of joint_a, joint_b and link [rad, rad, m].
        log_prior: Log prior probability of every hypothesis, shape `(H,)`.
        drift: Variance per metre that the factor of each wheel and wheelbase gains [1/m].
        gate: Threshold of the test for disturbed wheels [squared standard deviations].
        hold: Travel for which a disturbed wheel stays distrusted [m].
        distrust: Standard deviation of a distrusted wheel's travel, as a fraction of what it rolled.
        open_variance: Prior variance of the slow states in an open filter, shape `(11,)`.
        nominal_information: Prior inverse covariance of the slow states without suspects, `(11, 11)`.
        suspect_information: Direction U of each suspect in the slow states, times `nominal_information` P0,
            shape `(17, 11)`.
        suspect_precision: U P0 U', shape `(17, 17)`.
        suspect_value: 1 where a suspect changes one of `prior.VALUE_NAMES`, shape `(17, 9)`.
        size: Standard deviation of each suspect along its direction.
        odds: Log odds that a given suspect is present.
        independent_share: Step length over the correlation length of the errors: weight of a step's
            likelihood.
    """

    period: float
    noise: Annotated[Array, 4]
    trust: float
    memory: float
    resolution: Annotated[Array, 4]
    half_count: Annotated[Array, 3]
    log_prior: Annotated[Array, HYPOTHESIS_COUNT]
    drift: float
    gate: float
    hold: float
    distrust: float
    open_variance: Annotated[Array, 11]
    nominal_information: Annotated[Array, (11, 11)]
    suspect_information: Annotated[Array, (17, 11)]
    suspect_precision: Annotated[Array, (17, 17)]
    suspect_value: Annotated[IntArray, (17, 9)]
    size: Annotated[Array, 17]
    odds: float
    independent_share: float


class Step:
    """A step under one hypothesis, stored for the smoother; fields of `FilterState` and `OpenFilter`.

    Attributes:
        predicted: 1 where a step was finished; 0 for a first reading or a fix.
        mean: Estimate of the first six states, shape `(6,)`.
        offset: Open filter's estimate minus it, shape `(6,)`.
        covariance: Covariance of the open filter, shape `(19, 19)`.
        shift: How far the first six states moved to the mixture, shape `(6,)`.
        nonlinear_error: Error of the position that is not linear in that of the heading [m].
        step_travel: Travel of the wheels [m], shape `(4,)`.
        decay: Correlation of the error before and after the step.
        reading: Number in `hypotheses.READINGS` of the erroneous reading; -1 for none.
        row: Derivative of the mean readings by the states after the step, shape `(3, 19)`.
        transition: Derivative of the first six states by the states before the step, shape `(6, 19)`.
        inputs: Derivative of the first six states by the inputs, shape `(6, 8)`.
        input_variance: Variance of the inputs [m^2], shape `(8,)`.
        updated: 1 for joint_a, joint_b, link if the reading was informative, shape `(3,)`.
        gain: Covariance of the states with each reading, push and information, shape `(3, 21)`.
    """

    predicted: int
    mean: Annotated[Array, 6]
    offset: Annotated[Array, 6]
    covariance: Annotated[Array, (19, 19)]
    shift: Annotated[Array, 6]
    nonlinear_error: float
    step_travel: Annotated[Array, 4]
    decay: float
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
        is_linked: 1 since the linkage has been read.
        predicted: 1 where this sample finished a step.
        mean: Estimate of the states, shape `(19,)`: reading = true + error + bias,
            travel = rolled x (1 + factor). The error differs between hypotheses; it is 0 here.
        covariance: Covariance of the estimate's error, shape `(19, 19)`.
        score: Log likelihood of every hypothesis, shape `(H,)`.
        weight: Probability of each hypothesis, shape `(H,)`.
        is_replay: 1 if the smoother runs a block again, with the mixture of the first run.
        mixture_count: Number of times that the hypotheses were mixed.
        is_disturbed: 1 while a wheel is distrusted.
        move: Step from the estimate to the last mixture, shape `(19,)`.
        origin: Position of truck a at the start [m], shape `(2,)`.
        fix_count: Number of absolute poses applied so far.
        axle_variance: Variance of the angle between body and wheels of truck a [rad^2].
        nonlinear_error: Error of the position that is not linear in that of the heading [m]; without fixes.
        suspicion: Probability that each of `prior.VALUE_NAMES` is wrong, shape `(9,)`.
        shift: How far the first six states moved to the mixture after this sample, shape `(6,)`.
        step_start: Heading of the link, joint angles and length at the start of the step, shape `(4,)`.
        step_travel: Travel of the wheels since the start of the step [m], shape `(4,)`.
        last_step_travel: Travel of the wheels in the step that was finished last [m], shape `(4,)`.
        speed: Mean speed of the wheels in the step that was finished last [m/s], shape `(4,)`.
        speed_before: The same of the step before it [m/s], shape `(4,)`.
        rate: Mean rate of the two joints in the step that was finished last [rad/s], shape `(2,)`.
        rate_before: The same of the step before it [rad/s], shape `(2,)`.
        step_distance: Distance rolled since the start of the step [m], shape `(4,)`.
        samples: Samples since then.
        linkage_samples: Samples since then in which the linkage was read.
        readings: Samples so far in which the linkage was read in motion.
        residual_sum: Sum of reading minus prediction in them, shape `(3,)`.
        last_residual: Reading minus prediction in the last of them, shape `(3,)`.
        residual_change: Its change from the sample before, shape `(3,)`.
        squared_changes: Sum of squared changes since the start of the step, shape `(3,)`.
        reading_variance: Learned white noise of the readings [rad^2, rad^2, m^2], shape `(3,)`.
        mean_variance: Variance of the mean readings of this step [rad^2, rad^2, m^2], shape `(3,)`.
        half_width: Half-width of their remaining quantisation error [rad, rad, m], shape `(3,)`.
        transition: Derivative of the first six states by the states before the step, shape `(6, 19)`.
        inputs: Derivative of the first six states by the inputs, shape `(6, 8)`.
        levels: Variance per metre of wheels of a, wheels of b, sideways slip, slack [m], shape `(4,)`; this
            and all below is working memory for one open filter at a time.
        carried: Product of transition and covariance, shape `(6, 19)`.
        shares: Covariance of each wheel's lost travel with the states, shape `(4, 19)`.
        spread: Covariance of the innovations, shape `(3, 3)`.
        information: Its inverse, shape `(3, 3)`.
        pull: Product of the information and the innovations, shape `(3,)`.
        innovations: Mean readings minus predictions, shape `(3,)`.
        explained: Part of the squared innovation that each input explains, shape `(8,)`.
    """

    is_linked: int
    predicted: int
    mean: Annotated[Array, 19]
    covariance: Annotated[Array, (19, 19)]
    score: Annotated[Array, HYPOTHESIS_COUNT]
    weight: Annotated[Array, HYPOTHESIS_COUNT]
    is_replay: int
    mixture_count: int
    is_disturbed: int
    move: Annotated[Array, 19]
    origin: Annotated[Array, 2]
    fix_count: int
    axle_variance: float
    nonlinear_error: float
    suspicion: Annotated[Array, 9]
    shift: Annotated[Array, 6]
    step_start: Annotated[Array, 4]
    step_travel: Annotated[Array, 4]
    last_step_travel: Annotated[Array, 4]
    speed: Annotated[Array, 4]
    speed_before: Annotated[Array, 4]
    rate: Annotated[Array, 2]
    rate_before: Annotated[Array, 2]
    step_distance: Annotated[Array, 4]
    samples: int
    linkage_samples: int
    readings: int
    residual_sum: Annotated[Array, 3]
    last_residual: Annotated[Array, 3]
    residual_change: Annotated[Array, 3]
    squared_changes: Annotated[Array, 3]
    reading_variance: Annotated[Array, 3]
    mean_variance: Annotated[Array, 3]
    half_width: Annotated[Array, 3]
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
    """The open filter of one hypothesis; it changes only at the end of a step and at a fix.

    Attributes:
        number: Number of the hypothesis.
        reading: Number in `hypotheses.READINGS` of the erroneous reading; -1 for none.
        form: Form of the error, see `omnimate.ipec.filter.hypotheses`.
        variance: Prior variance of the error's sizes, in the units of its form, shape `(2,)`.
        correlation_length: Distance over which the error is correlated [m].
        play_position: Position of a joint within its play, from -1 to 1, see `omnimate.ipec.filter.forms`.
        mean_play_position: Its mean over this step.
        form_variance: Added variance of the reading in this step for errors of the form itself [rad^2].
        reading_sensitivity: Derivatives of joint_a, joint_b, link by the sizes in this step, `(2, 3)`.
        input_sensitivity: Derivatives of the inputs by the sizes in this step, shape `(8, 2)`.
        is_active: 1 if the hypothesis is computed; in a replay most are not.
        offset: Its estimate minus the mixture's mean, shape `(19,)`.
        row: Derivative of the mean readings by the states after the step, shape `(3, 19)`.
        covariance: Its covariance, shape `(19, 19)`.
        learned: Sums of the learned noise levels: variance, distance; shape `(4, 2)`.
        alert: Travel for which each input stays distrusted [m], shape `(8,)`.
        lost: Travel that each distrusted wheel lost in the last step [m], shape `(4,)`.
        nis: Normalised innovation squared of the last step, 3 degrees of freedom; nan without one.
        decay: Correlation of the error before and after this step.
        input_variance: Variance of the inputs in this step [m^2], shape `(8,)`.
        updated: 1 for joint_a, joint_b, link if the reading was informative, shape `(3,)`.
        gain: Covariance of the states with each reading `(19,)`, then shift and decrease by
            `truncate_normal`, shape `(3, 21)`.
    """

    number: int
    reading: int
    form: int
    variance: Annotated[Array, 2]
    correlation_length: float
    play_position: float
    mean_play_position: float
    form_variance: float
    reading_sensitivity: Annotated[Array, (2, 3)]
    input_sensitivity: Annotated[Array, (8, 2)]
    is_active: int
    offset: Annotated[Array, 19]
    row: Annotated[Array, (3, 19)]
    covariance: Annotated[Array, (19, 19)]
    learned: Annotated[Array, (4, 2)]
    alert: Annotated[Array, 8]
    lost: Annotated[Array, 4]
    nis: float
    decay: float
    input_variance: Annotated[Array, 8]
    updated: Annotated[IntArray, 3]
    gain: Annotated[Array, (3, 21)]
