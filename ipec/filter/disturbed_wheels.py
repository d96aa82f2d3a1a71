"""Which input was disturbed: a test of the innovations, wheel by wheel and side by side; compiled.

A wheel that loses travel, on a bump or by spinning, changes joint angles and link length in a ratio that
differs from wheel to wheel, and so does a truck that is pushed to the side. Where one input explains
innovations that noise does not explain, it is distrusted as long as the disturbance may last, and the
linkage and the other inputs determine the estimate.
"""

import math

from omnimate.ipec.filter.measurement import innovation, spread
from omnimate.ipec.filter.prediction import add_input, level_of
from omnimate.ipec.filter.records import (
    AHEAD,
    INPUTS,
    JOINT_A,
    SIDES,
    FilterSettings,
    FilterState,
    OpenFilter,
)
from omnimate.vehicle.compiled import Array, compiled
from omnimate.vehicle.matrices import invert_into, multiply

STEP = 0.05  # [m] of a wheel's travel, after which the covariance is carried on and readings are taken
AMBIGUOUS = 4.0  # [squared standard deviations] within which two inputs explain equally well
ATTEMPTS, FOR_WHEELS = 4, 2  # to explain an innovation, at first by wheels alone
PUSHED = math.log(1e3)  # odds of a bump, one in a metre (O 3), against a push, one in a kilometre
CLEARLY = 3.0  # times as much must be explained where it is not by a wheel
BRAKES = 0.95  # of the speed in the step before, below which a wheel may slip on: 0.5 m/s^2 at 0.7 m/s
FREEDOM = 4.0  # degrees of freedom of the heavy tails of innovations


@compiled
def square(information: Array, offsets: Array, pull: Array) -> float:
    """Fill the product of information `(3, 3)` and innovations `(3,)`; return the squared innovation."""
    multiply(pull, information, offsets)
    left: float = pull[0] * offsets[0] + pull[1] * offsets[1] + pull[2] * offsets[2]
    return left


@compiled
def by_input(state: FilterState, number: int, information: Array, pull: Array) -> tuple[float, float]:
    """Return how the innovations pull an input, and how much they say about it.

    `information` `(3, 3)` is the innovations' inverse covariance, `pull` `(3,)` its product with them.
    """
    along, weight = 0.0, 0.0
    for i in range(3):
        moved = state.inputs[JOINT_A + i, number]
        along += moved * pull[i]
        for j in range(3):
            weight += moved * information[i, j] * state.inputs[JOINT_A + j, number]
    return along, weight


@compiled
def explain(state: FilterState, opened: OpenFilter, number: int, information: Array, pull: Array) -> float:
    """Return how much of the squared innovation an input explains; arguments as for `by_input`.

    It is 0 where a wheel would have to gain travel, but for one that brakes: rubber slips on.
    """
    if opened.alert[number] > 0.0:
        return 0.0
    along, weight = by_input(state, number, information, pull)
    gains = number < 4 and along * state.way[number] >= 0.0
    if gains and abs(state.speed[number]) > BRAKES * abs(state.speed_before[number]):
        return 0.0
    return along * along / weight if weight > 0.0 else 0.0


@compiled
def density(left: float, information: Array) -> float:
    """Return the logarithm of the density of innovations, but for a constant, by Student's distribution.

    `left` is their square [squared standard deviations], `information` `(3, 3)` their inverse covariance.
    """
    a, b, c = information[0, 0], information[0, 1], information[0, 2]
    d, e, f = information[1, 1], information[1, 2], information[2, 2]
    determinant = a * (d * f - e * e) - b * (b * f - c * e) + c * (b * e - c * d)
    return 0.5 * math.log(determinant) - 0.5 * (FREEDOM + 3.0) * math.log1p(left / FREEDOM)


@compiled
def inputs_to_examine(settings: FilterSettings, attempt: int, left: float, scores: Array) -> tuple[int, int]:
    """Return the first of the inputs that an attempt examines, and that after the last.

    They are the wheels first. But a push to the side that explains alone what no wheel explains alone comes
    before two wheels: these do so only where they lose alike, to the resolution of the link. `scores` `(8,)`
    is what each input explains of the squared innovation `left`.
    """
    wheel, push = left - scores[:SIDES].max(), left - scores[SIDES:AHEAD].max()
    odds = 0.5 * (FREEDOM + 3.0) * (math.log1p(wheel / FREEDOM) - math.log1p(max(push, 0.0) / FREEDOM))
    if attempt == 0 and push < settings.gate and odds > PUSHED:
        return SIDES, AHEAD
    return (0, SIDES) if attempt < FOR_WHEELS else (SIDES, INPUTS)


@compiled
def find_disturbed(settings: FilterSettings, state: FilterState, opened: OpenFilter) -> None:
    """Distrust the inputs that explain what noise does not explain, and judge the hypothesis.

    The innovations' size is kept as `nis`, the logarithm of their density is added to the score.
    """
    offsets, scores, information, pull = state.innovations, state.explained, state.information, state.pull
    for number in range(3):
        offsets[number] = innovation(state, opened, number)
    spread(state, opened)
    invert_into(information, state.spread)
    left = square(information, offsets, pull)
    opened.nis = left
    share = min(1.0, state.rolled.max() / STEP)  # of what a whole step tells
    state.score[opened.number] += share * settings.independent * density(left, information)
    for attempt in range(ATTEMPTS):
        if left < settings.gate:
            break
        for number in range(INPUTS):
            scores[number] = explain(state, opened, number, information, pull)
        first, last = inputs_to_examine(settings, attempt, left, scores)
        best = scores[first:last].max()
        if best < (settings.gate if first == 0 else CLEARLY * settings.gate):
            continue
        for number in range(first, last):
            if scores[number] >= best - AMBIGUOUS and scores[number] > 0.0:
                _distrust(settings, state, opened, number)
        spread(state, opened)
        invert_into(information, state.spread)
        left = square(information, offsets, pull)
    learn_noise(settings, state, opened, information, pull, left)
    if left > settings.gate:  # nothing of these: all inputs scattered more than they do
        more = (left - 3.0) / FREEDOM
        for number in range(INPUTS):
            variance = more * opened.input_variance[number]
            opened.input_variance[number] += variance
            add_input(state, opened, number, variance)
        spread(state, opened)


@compiled
def learn_noise(
    settings: FilterSettings,
    state: FilterState,
    opened: OpenFilter,
    information: Array,
    pull: Array,
    left: float,
) -> None:
    """Learn the variance of the inputs from what the innovations say about them.

    One step of expectation maximisation (Shumway & Stoffer, 1982) with innovations of Student's
    distribution, so that a single disturbance teaches little. No step teaches more than a distrusted input
    may err by: what no hypothesis explains would else let the noise grow without a bound.
    """
    weight = (FREEDOM + 3.0) / (FREEDOM + left)
    way, learned = 0.25 * state.rolled.sum(), opened.learned
    fade = math.exp(-way / settings.memory)
    for level in range(4):
        learned[level, 0] *= fade
        learned[level, 1] *= fade
    for number in range(INPUTS):
        level = level_of(number)
        rolled = state.rolled[number] if number < 4 else way
        variance = opened.input_variance[number]
        if rolled <= 0.0 or variance <= 0.0 or opened.alert[number] > 0.0:
            continue
        along, seen = by_input(state, number, information, pull)
        likely = variance + variance * variance * (weight * along * along - seen)
        if number < 4:
            likely -= settings.resolution[number]
        most = (settings.distrust * rolled) ** 2
        learned[level, 0] += min(max(likely, 0.0), most)
        learned[level, 1] += rolled


@compiled
def find_levels(settings: FilterSettings, state: FilterState, opened: OpenFilter) -> None:
    """Fill the variance per metre of the inputs [m]: wheels of a, wheels of b, sideways, slack; `(4,)`."""
    for level in range(4):
        known = settings.noise[level] * settings.trust + opened.learned[level, 0]
        state.levels[level] = known / (settings.trust + opened.learned[level, 1])


@compiled
def _distrust(settings: FilterSettings, state: FilterState, opened: OpenFilter, number: int) -> None:
    opened.alert[number] = settings.hold
    way = state.rolled[number] if number < 4 else 0.25 * state.rolled.sum()
    variance = (settings.distrust * way) ** 2
    opened.input_variance[number] += variance
    add_input(state, opened, number, variance)
