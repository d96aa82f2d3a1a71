"""Which input was disturbed: a test of the innovations for every wheel and every truck; compiled.

A wheel that loses travel, on a bump or by spinning, changes joint angles and link length in a ratio that
differs from wheel to wheel, and so does a truck that is pushed sideways. An input that explains innovations
beyond the noise is distrusted for as long as the disturbance may last; meanwhile the linkage and the other
inputs determine the estimate.
"""

import math

from omnimate.ipec.filter.measurement import fill_innovation_covariance, innovation
from omnimate.ipec.filter.prediction import add_input, noise_level_of
from omnimate.ipec.filter.records import (
    AHEAD,
    INPUTS,
    JOINT_A,
    LINK,
    SIDES,
    FilterSettings,
    FilterState,
    OpenFilter,
)
from omnimate.vehicle.compiled import Array, compiled
from omnimate.vehicle.matrices import invert_into, multiply

STEP_LENGTH = 0.05  # [m] of travel between two updates; assumption: as long as a bump
EQUAL_SCORE_MARGIN = 4.0  # [squared standard deviations] two inputs closer than that are both distrusted
MAX_ATTEMPTS, WHEEL_ATTEMPTS = 4, 2  # inputs per step that are distrusted in turn, the first ones wheels
# Prior odds of a bump, one per metre (O 3), against a push, one per kilometre (assumption).
BUMP_TO_PUSH_LOG_ODDS = math.log(1e3)
# [1] That what no single wheel explains is two bumps at once, and no push: in 50 mm two bumps of one per
# metre, whose losses of up to 5 mm are equal to 0.1 mm (5e-5), against one push (5e-5).
TWO_BUMPS_PROBABILITY = 0.5
SLIP_GATE_FACTOR = 3.0  # [1] gate of slip of a truck, over the gate of a wheel; assumption: slip is rarer
# Speed over that in the previous step below which a wheel brakes, and may slip forward: 0.5 m/s^2 at 0.7 m/s.
BRAKING_SPEED_RATIO = 0.95
STUDENT_FREEDOM = 4.0  # degrees of freedom of the innovations' Student distribution; assumption: heavy tails


@compiled
def squared_innovation(information: Array, offsets: Array, pull: Array) -> float:
    """Fill the product of information `(3, 3)` and innovations `(3,)`; return the squared innovation."""
    multiply(pull, information, offsets)
    remaining: float = pull[0] * offsets[0] + pull[1] * offsets[1] + pull[2] * offsets[2]
    return remaining


@compiled
def project_on_input(state: FilterState, number: int, information: Array, pull: Array) -> tuple[float, float]:
    """Return the score of an input by the innovations, and its Fisher information.

    `information` `(3, 3)` is the innovations' inverse covariance, `pull` `(3,)` its product with them.
    """
    score, weight = 0.0, 0.0
    for i in range(3):
        response = state.inputs[JOINT_A + i, number]
        score += response * pull[i]
        for j in range(3):
            weight += response * information[i, j] * state.inputs[JOINT_A + j, number]
    return score, weight


@compiled
def explained_by_input(
    state: FilterState, opened: OpenFilter, number: int, information: Array, pull: Array
) -> float:
    """Return how much of the squared innovation an input explains; arguments as for `project_on_input`.

    It is 0 if a wheel would have to gain travel, unless it brakes: then rubber may slip forward.
    """
    if opened.alert[number] > 0.0:
        return 0.0
    score, weight = project_on_input(state, number, information, pull)
    gains = number < 4 and score * state.step_travel[number] >= 0.0
    if gains and abs(state.speed[number]) > BRAKING_SPEED_RATIO * abs(state.speed_before[number]):
        return 0.0
    return score * score / weight if weight > 0.0 else 0.0


@compiled
def student_log_density(remaining: float, information: Array) -> float:
    """Return the log density of innovations by Student's t distribution, up to a constant.

    `remaining` is their square [squared standard deviations], `information` `(3, 3)` their inverse
    covariance.
    """
    a, b, c = information[0, 0], information[0, 1], information[0, 2]
    d, e, f = information[1, 1], information[1, 2], information[2, 2]
    determinant = a * (d * f - e * e) - b * (b * f - c * e) + c * (b * e - c * d)
    return 0.5 * math.log(determinant) - 0.5 * (STUDENT_FREEDOM + 3.0) * math.log1p(
        remaining / STUDENT_FREEDOM
    )


@compiled
def inputs_to_examine(settings: FilterSettings, attempt: int, wheel: float, push: float) -> tuple[int, int]:
    """Return the range of the inputs that an attempt examines: the first, and one past the last.

    Wheels are examined first. But if one sideways push explains what no wheel explains alone, it is examined
    before pairs of wheels: a pair resembles a push only if both lose the same travel to the resolution of the
    link. `wheel` and `push` are what the best wheel and the best push leave of the squared innovation.
    """
    odds = (
        0.5
        * (STUDENT_FREEDOM + 3.0)
        * (math.log1p(wheel / STUDENT_FREEDOM) - math.log1p(max(push, 0.0) / STUDENT_FREEDOM))
    )
    if attempt == 0 and push < settings.gate and odds > BUMP_TO_PUSH_LOG_ODDS:
        return SIDES, AHEAD
    return (0, SIDES) if attempt < WHEEL_ATTEMPTS else (SIDES, INPUTS)


@compiled
def detect_disturbed_inputs(settings: FilterSettings, state: FilterState, opened: OpenFilter) -> None:
    """Distrust the inputs that explain innovations beyond the noise, and score the hypothesis.

    `nis` is set to the squared innovation, and its log density is added to the score.
    """
    offsets, information, pull = state.innovations, state.information, state.pull
    for number in range(3):
        offsets[number] = innovation(state, opened, number)
    fill_innovation_covariance(state, opened)
    invert_into(information, state.spread)
    remaining = squared_innovation(information, offsets, pull)
    opened.nis = remaining
    share = min(1.0, state.step_distance.max() / STEP_LENGTH)  # of the information of a full step
    state.score[opened.number] += (
        share * settings.independent_share * student_log_density(remaining, information)
    )
    for attempt in range(MAX_ATTEMPTS):
        if remaining < settings.gate:
            break
        if distrust_best(settings, state, opened, attempt, remaining):
            fill_innovation_covariance(state, opened)
            invert_into(information, state.spread)
            remaining = squared_innovation(information, offsets, pull)
    learn_noise(settings, state, opened, information, pull, remaining)
    if remaining > settings.gate:  # not explained by any input: inflate the variance of all
        more = (remaining - 3.0) / STUDENT_FREEDOM
        for number in range(INPUTS):
            variance = more * opened.input_variance[number]
            opened.input_variance[number] += variance
            add_input(state, opened, number, variance)
        fill_innovation_covariance(state, opened)


@compiled
def distrust_best(
    settings: FilterSettings, state: FilterState, opened: OpenFilter, attempt: int, remaining: float
) -> bool:
    """Distrust the inputs that explain most of the squared innovation; return whether any explains enough."""
    scores = state.explained
    for number in range(INPUTS):
        scores[number] = explained_by_input(state, opened, number, state.information, state.pull)
    wheel, push = remaining - scores[:SIDES].max(), remaining - scores[SIDES:AHEAD].max()
    first, last = inputs_to_examine(settings, attempt, wheel, push)
    best = scores[first:last].max()
    if best < (settings.gate if first == 0 else SLIP_GATE_FACTOR * settings.gate):
        return False
    if attempt == 0 and wheel > settings.gate:
        doubt_heading(state, opened, SIDES + int(scores[SIDES:AHEAD].argmax()))
    for number in range(first, last):
        if scores[number] >= best - EQUAL_SCORE_MARGIN and scores[number] > 0.0:
            _distrust(settings, state, opened, number)
    return True


@compiled
def learn_noise(
    settings: FilterSettings,
    state: FilterState,
    opened: OpenFilter,
    information: Array,
    pull: Array,
    remaining: float,
) -> None:
    """Update the learned variances of the inputs from the innovations.

    One step of expectation maximisation (Shumway & Stoffer, 1982) with innovations of Student's
    distribution, so that one disturbance has little weight. The increment of a step is limited to the error
    of a distrusted input: otherwise an error that no hypothesis explains would let the noise grow without
    bound.
    """
    weight = (STUDENT_FREEDOM + 3.0) / (STUDENT_FREEDOM + remaining)
    distance, learned = 0.25 * state.step_distance.sum(), opened.learned
    fade = math.exp(-distance / settings.memory)
    for level in range(4):
        learned[level, 0] *= fade
        learned[level, 1] *= fade
    for number in range(INPUTS):
        level = noise_level_of(number)
        rolled = state.step_distance[number] if number < 4 else distance
        variance = opened.input_variance[number]
        if rolled <= 0.0 or variance <= 0.0 or opened.alert[number] > 0.0:
            continue
        score, evidence = project_on_input(state, number, information, pull)
        likely = variance + variance * variance * (weight * score * score - evidence)
        if number < 4:
            likely -= settings.resolution[number]
        most = (settings.distrust * rolled) ** 2
        learned[level, 0] += min(max(likely, 0.0), most)
        learned[level, 1] += rolled


@compiled
def fill_noise_levels(settings: FilterSettings, state: FilterState, opened: OpenFilter) -> None:
    """Fill the variance per metre of the inputs [m]: wheels of a, wheels of b, sideways, slack; `(4,)`."""
    for level in range(4):
        known = settings.noise[level] * settings.trust + opened.learned[level, 0]
        state.levels[level] = known / (settings.trust + opened.learned[level, 1])


@compiled
def doubt_heading(state: FilterState, opened: OpenFilter, push: int) -> None:
    """Add the variance of the heading where no single wheel, but a push or two bumps, explain the readings.

    A push of one truck turns the link against both trucks. Two wheels, one of each truck, that lose the same
    travel turn both trucks by that angle, and not the link; the readings are the same. Argument `push` is the
    number of the input.
    """
    score, weight = project_on_input(state, push, state.information, state.pull)
    turned = state.inputs[LINK, push] * score / weight
    opened.covariance[LINK, LINK] += TWO_BUMPS_PROBABILITY * turned * turned


@compiled
def _distrust(settings: FilterSettings, state: FilterState, opened: OpenFilter, number: int) -> None:
    opened.alert[number] = settings.hold
    distance = state.step_distance[number] if number < 4 else 0.25 * state.step_distance.sum()
    variance = (settings.distrust * distance) ** 2
    opened.input_variance[number] += variance
    add_input(state, opened, number, variance)
