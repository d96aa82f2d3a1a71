"""The filter of a robot with a single truck: dead reckoning corrected by absolute poses.

An extended Kalman filter (Chong & Kleeman, 1997, for the noise of the wheels) of the pose and of the errors
of both wheel diameters and of the wheelbase, which poses make visible. Live and over a recording it is the
same compiled step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import numpy as np

from omnimate.ipec.corrector import ORIGIN
from omnimate.ipec.filter.fixes import fix_at_sample, fix_sigma, motion_to_fixes, samples_at
from omnimate.ipec.filter.prior import BASE, CALIBRATED, DIAMETER, FilterNoise, Prior
from omnimate.ipec.readings import columns_of, read_sample
from omnimate.vehicle.arcs import SMALL_SLOPE_ANGLE, roll, sinc_of
from omnimate.vehicle.compiled import Array, IntArray, Record, compiled, compiled_without_lock, record
from omnimate.vehicle.matrices import add_outer, product
from omnimate.vehicle.odometry import wheels_of
from omnimate.vehicle.se2 import wrap_angle

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from omnimate.vehicle.parameters import VehicleParameters
    from omnimate.vehicle.recording import Poses, Recording
    from omnimate.vehicle.sample import Sample

HEADING, FACTOR, STATES = 2, 3, 6  # numbers of the heading and of the first factor; number of the states
# [standard deviations] An innovation beyond it counts as much as one there (Huber, 1964).
HUBER_LIMIT = 3.0
# Wild poses in a row after which the robot was moved by somebody: one in a thousand where one in ten is wild.
MOVED_AFTER = 3


class OneTruckSettings:
    """Constants of the filter."""

    scale: Annotated[Array, 2]  # metres per count of the left and the right wheel
    wheelbase: float  # nominal wheelbase [m]
    roughness: float  # variance of a wheel's travel after one metre [m]
    drift: float  # variance of the change of a factor in one metre [1/m]


class OneTruckRecord:
    """The estimate after a sample."""

    started: int  # 1 once both wheels were read
    wild: int  # number of wild poses since the last one that was not
    counts: Annotated[IntArray, 2]  # counts of the left and the right wheel when both were last read
    mean: Annotated[Array, STATES]  # pose [m, m, rad]; true over nominal diameters and wheelbase, minus 1
    covariance: Annotated[Array, (STATES, STATES)]  # its covariance


@compiled
def fill_transition(mean: Array, rolled: tuple[float, float], wheelbase: float, transition: Array) -> None:
    """Fill the derivative `(6, 6)` of the states after a movement by those before it, `mean` `(6,)`.

    `rolled` is the travel of the left and the right wheel with nominal diameters, `wheelbase` nominal [m].
    """
    base = wheelbase * (1.0 + mean[FACTOR + 2])
    travel = 0.5 * (rolled[0] * (1.0 + mean[FACTOR]) + rolled[1] * (1.0 + mean[FACTOR + 1]))
    turn = (rolled[1] * (1.0 + mean[FACTOR + 1]) - rolled[0] * (1.0 + mean[FACTOR])) / base
    half = 0.5 * turn
    chord = sinc_of(half)
    slope = -half / 6.0 if abs(half) < SMALL_SLOPE_ANGLE else 0.5 * (math.cos(half) - chord) / half
    cos, sin = math.cos(mean[HEADING] + half), math.sin(mean[HEADING] + half)
    transition[:] = 0.0
    for state in range(STATES):
        transition[state, state] = 1.0
    transition[0, HEADING], transition[1, HEADING] = -travel * chord * sin, travel * chord * cos
    by_turn = travel * (slope * cos - 0.5 * chord * sin), travel * (slope * sin + 0.5 * chord * cos), 1.0
    by_travel = chord * cos, chord * sin, 0.0
    for axis in range(3):
        transition[axis, FACTOR] = rolled[0] * (0.5 * by_travel[axis] - by_turn[axis] / base)
        transition[axis, FACTOR + 1] = rolled[1] * (0.5 * by_travel[axis] + by_turn[axis] / base)
        transition[axis, FACTOR + 2] = -turn / (1.0 + mean[FACTOR + 2]) * by_turn[axis]


@compiled
def predict(settings: OneTruckSettings, state: OneTruckRecord, counts: IntArray) -> None:
    """Move the estimate by the counts `(2,)` of the left and the right wheel, in place."""
    rolled = (
        settings.scale[0] * (counts[0] - state.counts[0]),
        settings.scale[1] * (counts[1] - state.counts[1]),
    )
    state.counts[:] = counts
    if not state.started:
        state.started = 1
        return
    distance = 0.5 * (abs(rolled[0]) + abs(rolled[1]))
    if distance == 0.0:
        return
    transition, carried = np.empty((STATES, STATES)), np.empty((STATES, STATES))
    fill_transition(state.mean, rolled, settings.wheelbase, transition)
    product(carried, transition, state.covariance)
    product(state.covariance, carried, transition.T)
    by_metre = np.zeros(STATES)  # of a wheel's travel
    for wheel in range(2):
        if rolled[wheel] != 0.0:
            for axis in range(3):
                by_metre[axis] = transition[axis, FACTOR + wheel] / rolled[wheel]
            add_outer(state.covariance, settings.roughness * abs(rolled[wheel]), by_metre)
    for factor in range(FACTOR, STATES):
        state.covariance[factor, factor] += settings.drift * distance
    mean = state.mean
    left, right = rolled[0] * (1.0 + mean[FACTOR]), rolled[1] * (1.0 + mean[FACTOR + 1])
    roll(mean, left, right, settings.wheelbase * (1.0 + mean[FACTOR + 2]))


@compiled
def update(states: Record, pose: Array, sigma: Array) -> None:
    """Update the estimate, a record `(1,)`, by an absolute pose `(3,)` [m, m, rad] and its sigma, in place.

    Coordinates that are nan are skipped.
    """
    mean, covariance = states[0].mean, states[0].covariance
    gain, moved, is_wild = np.empty(STATES), states[0].wild >= MOVED_AFTER, False
    for axis in range(3):
        innovation = pose[axis] - mean[axis]
        if math.isnan(innovation):
            continue
        if axis == HEADING:
            innovation = wrap_angle(innovation)
        variance = covariance[axis, axis] + sigma[axis] * sigma[axis]
        off = abs(innovation) / math.sqrt(variance)
        if off > HUBER_LIMIT:
            is_wild = True
            if moved:
                covariance[axis, axis] += innovation * innovation
                variance += innovation * innovation
            else:
                variance *= off / HUBER_LIMIT
        gain[:] = covariance[axis]
        add_outer(covariance, -1.0 / variance, gain)
        for state in range(STATES):
            mean[state] += gain[state] * innovation / variance
    states[0].wild = states[0].wild + 1 if is_wild else 0


@compiled
def step(settings: Record, states: Record, counts: IntArray, present: NDArray[np.bool_]) -> None:
    """Process one sample, of which the truck's wheels `(2,)` are used where both are present, in place."""
    if present[0] and present[1]:
        predict(settings[0], states[0], counts)


@compiled_without_lock
def run(
    settings: Record,
    states: Record,
    counts: IntArray,
    present: NDArray[np.bool_],
    fixed: IntArray,
    fixes: tuple[Array, Array, Array],
    poses: Array,
    sigmas: Array,
) -> None:
    """Run the filter over all samples; the state `(1,)` becomes that after the last one.

    Counts and presence `(N, 2)` are those of the left and the right wheel. Poses, motions since the sample
    and standard deviations in `fixes`, each `(K, 3)`, are applied after the samples `fixed` `(K,)`,
    ascending. Filled are the pose after each sample and its standard deviations, `(N, 3)`.
    """
    following = 0
    for sample in range(len(counts)):
        step(settings, states, counts[sample], present[sample])
        while following < len(fixed) and fixed[following] <= sample:
            pose = fix_at_sample(fixes[0][following], fixes[1][following], states[0].mean)
            update(states, pose, fixes[2][following])
            following += 1
        for axis in range(3):
            poses[sample, axis] = states[0].mean[axis]
            sigmas[sample, axis] = math.sqrt(max(states[0].covariance[axis, axis], 0.0))


@dataclass(frozen=True, slots=True)
class OneTruckState:
    """The estimate after a sample. It is never changed: each step returns another one."""

    record: Record  # the estimate as one record `(1,)` of `OneTruckRecord`

    @property
    def pose(self) -> Array:
        """Pose of the truck [m, m, rad], shape `(3,)`."""
        return np.array(self.record["mean"][0, :3])

    @property
    def sigma(self) -> Array:
        """Its standard deviations [m, m, rad], shape `(3,)`."""
        return np.sqrt(np.maximum(np.diag(self.record["covariance"][0])[:3], 0.0))


class OneTruckFilter:
    """The filter of a robot's truck a, whether it has another one or not; arguments are those of `Filter`."""

    def __init__(
        self, vehicle: VehicleParameters, noise: FilterNoise | None = None, prior: Prior | None = None
    ) -> None:
        noise, self.prior = noise or FilterNoise(), prior or CALIBRATED
        wheels = wheels_of("a")
        self.columns = columns_of(vehicle, wheels)
        self.settings = record(OneTruckSettings)
        self.settings["scale"] = [vehicle.metres_per_count(wheel) for wheel in wheels]
        self.settings["wheelbase"] = vehicle.trucks["a"].wheelbase
        self.settings["roughness"], self.settings["drift"] = noise.roughness**2, noise.drift**2

    def start(self, pose: ArrayLike = ORIGIN, sigma: ArrayLike = (0.0, 0.0, 0.0)) -> OneTruckState:
        """Return the state before the first sample, at a pose with standard deviations [m, m, rad]."""
        begun, prior = record(OneTruckRecord), self.prior
        begun["mean"][0, :3] = pose
        covariance = begun["covariance"][0]
        covariance[[0, 1, 2], [0, 1, 2]] = np.square(sigma)
        # Variance of a value that is as described, or wrong with the probability `wrong`.
        covariance[FACTOR:-1, FACTOR:-1] = prior.covariance[:2, :2] + prior.wrong * DIAMETER**2 * np.eye(2)
        covariance[-1, -1] = prior.wheelbase**2 + prior.wrong * BASE**2
        return OneTruckState(begun)

    def step(self, state: OneTruckState, sample: Sample) -> OneTruckState:
        """Return the state after a sample; `state` is not changed."""
        following = state.record.copy()
        step(self.settings, following, *read_sample(sample, self.columns))
        return OneTruckState(following)

    def fix(self, state: OneTruckState, pose: ArrayLike, sigma: ArrayLike) -> OneTruckState:
        """Return the state after an absolute pose `(3,)` [m, m, rad], measured at its last sample.

        A coordinate that was not measured is nan, as is a standard deviation that none stated.
        """
        following = state.record.copy()
        update(following, np.asarray(pose, np.float64), fix_sigma(sigma))
        return OneTruckState(following)


def estimate_one_truck(
    recording: Recording,
    start: ArrayLike = ORIGIN,
    sigma: ArrayLike = (0.0, 0.0, 0.0),
    *,
    fixes: Poses | None = None,
    prior: Prior | None = None,
) -> tuple[Array, Array]:
    """Return poses and standard deviations `(N, 3)` [m, m, rad] of truck a, given the samples up to each.

    Arguments are those of `estimate`.
    """
    filter_ = OneTruckFilter(recording.vehicle, prior=prior)
    poses, sigmas = np.empty((len(recording), 3)), np.empty((len(recording), 3))
    samples, measured = np.zeros(0, np.int64), (np.zeros((0, 3)),) * 3
    if fixes is not None:
        of_a = fixes.of("a")
        samples = samples_at(recording, of_a.time)
        # a copy: read-only arrays would compile `run` a second time
        measured = of_a.pose.copy(), motion_to_fixes(recording, "a", of_a.time), fix_sigma(of_a.sigma)
    run(
        filter_.settings,
        filter_.start(start, sigma).record,
        np.ascontiguousarray(recording.counts[:, filter_.columns]),
        np.ascontiguousarray(recording.present[:, filter_.columns]),
        samples,
        measured,
        poses,
        sigmas,
    )
    return poses, sigmas
