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
    """Constants of the filter for one robot."""

    period: float  # time between two samples [s]
    noise: Annotated[Array, 4]  # initial variance per metre: wheels of a and of b, sideways slip, slack [m]
    trust: float  # distance that the initial levels count for [m]
    memory: float  # distance over which learned levels are forgotten [m]
    resolution: Annotated[Array, 4]  # variance of each wheel's travel in a step from its resolution [m^2]
    half_count: Annotated[Array, 3]  # half a count of joint_a, joint_b and link [rad, rad, m]
    log_prior: Annotated[Array, HYPOTHESIS_COUNT]  # log prior probability of every hypothesis
    drift: float  # variance per metre that the factor of each wheel and wheelbase gains [1/m]
    gate: float  # threshold of the test for disturbed wheels [squared standard deviations]
    hold: float  # travel for which a disturbed wheel stays distrusted [m]
    distrust: float  # standard deviation of a distrusted wheel's travel, as a fraction of what it rolled
    open_variance: Annotated[Array, 11]  # prior variance of the slow states in an open filter
    nominal_information: Annotated[Array, (11, 11)]  # prior information P0 on the slow states, no suspects
    suspect_information: Annotated[Array, (17, 11)]  # directions U of the suspects in them, times P0
    suspect_precision: Annotated[Array, (17, 17)]  # U P0 U'
    suspect_value: Annotated[IntArray, (17, 9)]  # 1 where a suspect changes one of `prior.VALUE_NAMES`
    size: Annotated[Array, 17]  # standard deviation of each suspect along its direction
    odds: float  # log odds that a given suspect is present
    independent_share: float  # weight of a step's likelihood: its length over the errors' correlation length


class Step:
    """A step under one hypothesis, stored for the smoother; fields of `FilterState` and `OpenFilter`."""

    predicted: int  # 1 where a step was finished; 0 for a first reading or a fix
    mean: Annotated[Array, 6]  # estimate of the first six states
    offset: Annotated[Array, 6]  # open filter's estimate minus it
    covariance: Annotated[Array, (19, 19)]  # covariance of the open filter
    shift: Annotated[Array, 6]  # how far the first six states moved to the mixture
    nonlinear_error: float  # error of the position not linear in that of the heading [m]
    step_travel: Annotated[Array, 4]  # travel of the wheels [m]
    decay: float  # correlation of the error before and after the step
    reading: int  # number in `hypotheses.READINGS` of the erroneous reading; -1 for none
    row: Annotated[Array, (3, 19)]  # derivative of the mean readings by the states after the step
    transition: Annotated[Array, (6, 19)]  # derivative of the first six states by the states before the step
    inputs: Annotated[Array, (6, 8)]  # derivative of the first six states by the inputs
    input_variance: Annotated[Array, 8]  # variance of the inputs [m^2]
    updated: Annotated[IntArray, 3]  # 1 for joint_a, joint_b, link if the reading was informative
    gain: Annotated[Array, (3, 21)]  # covariance of the states with each reading, push and information


class FilterState(Reading):
    """The estimate after a sample, and the step that led to it."""

    is_linked: int  # 1 since the linkage has been read
    predicted: int  # 1 where this sample finished a step
    # Estimate of the states: reading = true + error + bias, travel = rolled x (1 + factor). The error differs
    # between hypotheses; it is 0 here
    mean: Annotated[Array, 19]
    covariance: Annotated[Array, (19, 19)]  # covariance of the estimate's error
    score: Annotated[Array, HYPOTHESIS_COUNT]  # log likelihood of every hypothesis
    weight: Annotated[Array, HYPOTHESIS_COUNT]  # probability of each hypothesis
    is_replay: int  # 1 if the smoother runs a block again, with the mixture of the first run
    mixture_count: int  # number of times that the hypotheses were mixed
    is_disturbed: int  # 1 while a wheel is distrusted
    move: Annotated[Array, 19]  # step from the estimate to the last mixture
    origin: Annotated[Array, 2]  # position of truck a at the start [m]
    fix_count: int  # number of absolute poses applied so far
    axle_variance: float  # variance of the angle between body and wheels of truck a [rad^2]
    nonlinear_error: float  # error of the position not linear in that of the heading [m]; without fixes
    suspicion: Annotated[Array, 9]  # probability that each of `prior.VALUE_NAMES` is wrong
    shift: Annotated[Array, 6]  # how far the first six states moved to the mixture after this sample
    step_start: Annotated[Array, 4]  # heading of the link, joint angles and length at the start of the step
    step_travel: Annotated[Array, 4]  # travel of the wheels since the start of the step [m]
    last_step_travel: Annotated[Array, 4]  # travel of the wheels in the step that was finished last [m]
    speed: Annotated[Array, 4]  # mean speed of the wheels in the step that was finished last [m/s]
    speed_before: Annotated[Array, 4]  # the same of the step before it [m/s]
    rate: Annotated[Array, 2]  # mean rate of the two joints in the step that was finished last [rad/s]
    rate_before: Annotated[Array, 2]  # the same of the step before it [rad/s]
    extensions: Annotated[Array, 4]  # of the link at the start of the last steps, 0.2 m, in order of time [m]
    step_distance: Annotated[Array, 4]  # distance rolled since the start of the step [m]
    samples: int  # samples since then
    linkage_samples: int  # samples since then in which the linkage was read
    readings: int  # samples so far in which the linkage was read in motion
    residual_sum: Annotated[Array, 3]  # sum of reading minus prediction in them
    last_residual: Annotated[Array, 3]  # reading minus prediction in the last of them
    residual_change: Annotated[Array, 3]  # its change from the sample before
    squared_changes: Annotated[Array, 3]  # sum of squared changes since the start of the step
    reading_variance: Annotated[Array, 3]  # learned white noise of the readings [rad^2, rad^2, m^2]
    mean_variance: Annotated[Array, 3]  # variance of the mean readings of this step [rad^2, rad^2, m^2]
    half_width: Annotated[Array, 3]  # half-width of their remaining quantisation error [rad, rad, m]
    transition: Annotated[Array, (6, 19)]  # derivative of the first six states by the states before the step
    inputs: Annotated[Array, (6, 8)]  # derivative of the first six states by the inputs
    # Variance per metre of wheels of a, wheels of b, sideways slip, slack [m]; this and all below is working
    # memory for one open filter at a time
    levels: Annotated[Array, 4]
    carried: Annotated[Array, (6, 19)]  # product of transition and covariance
    shares: Annotated[Array, (4, 19)]  # covariance of each wheel's lost travel with the states
    spread: Annotated[Array, (3, 3)]  # covariance of the innovations
    information: Annotated[Array, (3, 3)]  # its inverse
    pull: Annotated[Array, 3]  # product of the information and the innovations
    innovations: Annotated[Array, 3]  # mean readings minus predictions
    explained: Annotated[Array, 8]  # part of the squared innovation that each input explains


class OpenFilter:
    """The open filter of one hypothesis; it changes only at the end of a step and at a fix."""

    number: int  # number of the hypothesis
    reading: int  # number in `hypotheses.READINGS` of the erroneous reading; -1 for none
    form: int  # form of the error, see `omnimate.ipec.filter.hypotheses`
    variance: Annotated[Array, 2]  # prior variance of the error's sizes, in the units of its form
    correlation_length: float  # distance over which the error is correlated [m]
    play_position: float  # of a joint within its play, -1 to 1, see `omnimate.ipec.filter.forms`
    mean_play_position: float  # its mean over this step
    form_variance: float  # added variance of the reading in this step for errors of the form itself [rad^2]
    reading_sensitivity: Annotated[Array, (2, 3)]  # derivatives of joint_a, joint_b, link by the sizes
    input_sensitivity: Annotated[Array, (8, 2)]  # derivatives of the inputs by the sizes in this step
    is_active: int  # 1 if the hypothesis is computed; in a replay most are not
    offset: Annotated[Array, 19]  # its estimate minus the mixture's mean
    row: Annotated[Array, (3, 19)]  # derivative of the mean readings by the states after the step
    covariance: Annotated[Array, (19, 19)]  # its covariance
    learned: Annotated[Array, (4, 2)]  # sums of the learned noise levels: variance, distance
    alert: Annotated[Array, 8]  # travel for which each input stays distrusted [m]
    lost: Annotated[Array, 4]  # travel that each distrusted wheel lost in the last step [m]
    nis: float  # normalised innovation squared of the last step, 3 degrees of freedom; nan without one
    decay: float  # correlation of the error before and after this step
    input_variance: Annotated[Array, 8]  # variance of the inputs in this step [m^2]
    updated: Annotated[IntArray, 3]  # 1 for joint_a, joint_b, link if the reading was informative
    gain: Annotated[Array, (3, 21)]  # covariance of states with each reading, then both of `truncate_normal`
