"""The filter over a recording: poses, their uncertainty, and disturbed wheels."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from omnimate.ipec.corrector import ORIGIN
from omnimate.ipec.filter.findings import (
    Disturbance,
    Findings,
    SlowParameters,
    find_disturbances,
    findings,
    slow_parameters,
)
from omnimate.ipec.filter.fixes import apply_fix, fix_records
from omnimate.ipec.filter.live import Filter
from omnimate.ipec.filter.poses import fill_pose
from omnimate.ipec.filter.records import HYPOTHESIS_COUNT, POSE, STATES, FilterState
from omnimate.ipec.filter.step import finish_step, predict
from omnimate.ipec.linkage_check import check_linkage
from omnimate.ipec.readings import ordered_counts
from omnimate.vehicle.compiled import Array, IntArray, Record, compiled_without_lock, layout

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from omnimate.ipec.filter.prior import FilterNoise, Prior
    from omnimate.vehicle.recording import Poses, Recording

BLOCK_SAMPLES = 1024  # samples between two checkpoints


@dataclass(frozen=True, slots=True)
class Estimate:
    """Poses of both trucks at every sample of a recording, disturbances and encoder errors.

    Attributes:
        time: Time of each sample on the recording's clock [s], shape `(N,)`.
        pose_a: Pose of truck a at each sample [m, m, rad], shape `(N, 3)`; headings are continuous.
        pose_b: Pose of truck b, shape `(N, 3)`; nan until the linkage has been read.
        sigma_a: Standard deviations of `pose_a` [m, m, rad], shape `(N, 3)`.
        sigma_b: Standard deviations of `pose_b` [m, m, rad], shape `(N, 3)`.
        lost: Travel that disturbed wheels lost in each sample [m], in the order of `WHEELS`, `(N, 4)`.
        nis: Normalised innovation squared of each sample, 3 degrees of freedom, shape `(N,)`; nan where
            no reading was used.
        disturbances: Disturbances with 0.7 mm of lost travel or more, in order of time.
        slow: Systematic errors of the encoders, estimated at the end of the recording.
        findings: Contradictions of the robot's description at the end of the recording.
    """

    time: Array
    pose_a: Array
    pose_b: Array
    sigma_a: Array
    sigma_b: Array
    lost: Array
    nis: Array
    disturbances: tuple[Disturbance, ...]
    slow: SlowParameters
    findings: Findings


class Table(NamedTuple):
    """A recording as input of the compiled loops."""

    counts: IntArray  # counts in the order of `CHANNELS`, `(N, 7)`
    present: NDArray[np.bool_]  # whether each count was read, `(N, 7)`
    fixes: Record  # absolute poses in order of time, `(K,)` records of `Fix`; the loops fill their gains


class Trace(NamedTuple):
    """Results of the filter at every sample, and checkpoints for the smoother."""

    poses: Array  # poses of truck a and b [m, m, rad], `(2, N, 3)`
    sigmas: Array  # their standard deviations, `(2, N, 3)`
    lost: Array  # travel that each wheel lost [m], `(N, 4)`
    alert: Array  # travel for which each wheel stays distrusted [m], `(N, 4)`
    nis: Array  # normalised innovation squared, `(N,)`
    means: Array  # first six states, `(N, 6)`
    checkpoints: Record  # state before each block of `BLOCK_SAMPLES` samples, `(B,)` records of `FilterState`
    filter_checkpoints: Record  # open filters before each block, `(B, H)` records of `OpenFilter`
    moves: Array  # moves of the estimate to the mixture, see `move_to_mixture`, `(D, 21)`


@dataclass(frozen=True, slots=True)
class ForwardRun:
    """A run of the filter over a recording."""

    estimate: Estimate  # filtered estimate at every sample
    settings: Record  # the filter's settings, one record `(1,)` of `FilterSettings`
    table: Table  # the recording
    trace: Trace  # trace of the run
    last: Record  # the state after the last sample, one record `(1,)`
    filters: Record  # the open filters after it, records `(H,)`


@compiled_without_lock
def trace_filter(settings: Record, states: Record, filters: Record, table: Table, trace: Trace) -> None:
    """Run the filter over all samples and fill the trace.

    `states` `(1,)` and `filters` `(H,)` are changed to those after the last sample.
    """
    state, fixes = states[0], table.fixes
    for sample in range(len(table.counts)):
        if sample % BLOCK_SAMPLES == 0:
            trace.checkpoints[sample // BLOCK_SAMPLES] = state
            for hypothesis in range(HYPOTHESIS_COUNT):
                trace.filter_checkpoints[sample // BLOCK_SAMPLES, hypothesis] = filters[hypothesis]
        if predict(settings, states, table.counts[sample], table.present[sample]):
            finish_step(settings, states, filters, trace.moves)
        while state.fix_count < len(fixes) and fixes[state.fix_count].sample <= sample:
            apply_fix(settings, states, filters, fixes[state.fix_count], trace.moves)
        for truck in range(2):
            fill_pose(
                state.mean, state.covariance, truck, trace.poses[truck, sample], trace.sigmas[truck, sample]
            )
        if not state.is_linked:
            trace.poses[1, sample], trace.sigmas[1, sample] = math.nan, math.nan
        likely = filters[state.weight.argmax()]
        trace.alert[sample] = likely.alert[:4]
        trace.lost[sample], trace.nis[sample] = 0.0, math.nan
        if state.predicted:
            trace.lost[sample], trace.nis[sample] = likely.lost, likely.nis
        trace.means[sample] = state.mean[:POSE]


def run_forward(
    recording: Recording,
    start: ArrayLike,
    sigma: ArrayLike,
    fixes: Poses | None,
    prior: Prior | None,
    noise: FilterNoise | None = None,
) -> ForwardRun:
    """Run the filter over a recording; arguments and errors are those of `estimate`."""
    check_linkage(recording)
    filter_ = Filter(recording.vehicle, noise, prior)
    begun = filter_.start(start, sigma)
    state, filters = begun.record.copy(), begun.filters.copy()
    table = Table(*ordered_counts(recording), fix_records(recording, fixes))
    count, decisions = len(recording), len(recording) + 2 * len(table.fixes)
    blocks = -(-count // BLOCK_SAMPLES)
    trace = Trace(
        np.empty((2, count, 3)),
        np.empty((2, count, 3)),
        np.empty((count, 4)),
        np.empty((count, 4)),
        np.empty(count),
        np.empty((count, POSE)),
        np.zeros(blocks, layout(FilterState)),
        np.zeros((blocks, HYPOTHESIS_COUNT), filters.dtype),
        np.empty((decisions, STATES + 2)),
    )
    trace_filter(filter_.settings, state, filters, table, trace)
    pose_a, pose_b = trace.poses
    sigma_a, sigma_b = trace.sigmas
    result = Estimate(
        recording.time,
        pose_a,
        pose_b,
        sigma_a,
        sigma_b,
        trace.lost,
        trace.nis,
        find_disturbances(recording.time, trace.alert, trace.lost),
        slow_parameters(state["mean"][0], state["covariance"][0]),
        findings(filter_.settings, state, filters),
    )
    return ForwardRun(result, filter_.settings, table, trace, state, filters)


def estimate(
    recording: Recording,
    start: ArrayLike = ORIGIN,
    sigma: ArrayLike = (0.0, 0.0, 0.0),
    *,
    fixes: Poses | None = None,
    noise: FilterNoise | None = None,
    prior: Prior | None = None,
) -> Estimate:
    """Return the filtered estimate at every sample of a recording, given the samples up to it.

    Args:
        recording: Recording of a robot with two trucks.
        start: Pose of truck a at the first sample [m, m, rad], shape `(3,)`.
        sigma: Standard deviations of `start` [m, m, rad], shape `(3,)`.
        fixes: Absolute poses to use, such as `recording.poses`; None for none. Where they state no standard
            deviation, it is 5 mm and 10 mrad.
        noise: Scatter of floor and encoders; `FilterNoise()` where it is None.
        prior: How well `recording.vehicle` is known; `CALIBRATED` where it is None.

    Raises:
        NoLinkageError: The robot has a single truck.
        LinkageChannelError: A channel of the linkage was never read, or was frozen while the robot moved.
    """
    return run_forward(recording, start, sigma, fixes, prior, noise).estimate
