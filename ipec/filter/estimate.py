"""A whole recording through the filter: poses, their uncertainty, and which wheels were disturbed."""

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
from omnimate.ipec.filter.fixes import apply_fixes, fix_records
from omnimate.ipec.filter.live import Filter
from omnimate.ipec.filter.poses import look
from omnimate.ipec.filter.records import BANK, POSE, STATES, FilterState
from omnimate.ipec.filter.step import advance
from omnimate.ipec.linkage_check import check_linkage
from omnimate.ipec.readings import table_of
from omnimate.vehicle.compiled import Array, IntArray, Record, compiled_without_lock, layout

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from omnimate.ipec.filter.prior import FilterNoise, Prior
    from omnimate.vehicle.recording import Poses, Recording

BLOCK = 1024  # samples after which the filter's state is kept


@dataclass(frozen=True, slots=True)
class Estimate:
    """The poses of both trucks at every sample of a recording, and what else was estimated.

    Attributes:
        time: Time of each sample on the recording's clock [s], shape `(N,)`.
        pose_a: Pose of truck a at each sample [m, m, rad], shape `(N, 3)`; headings are continuous.
        pose_b: Pose of truck b, shape `(N, 3)`; nan until the linkage has been read.
        sigma_a: Standard deviations of `pose_a` [m, m, rad], shape `(N, 3)`.
        sigma_b: Standard deviations of `pose_b` [m, m, rad], shape `(N, 3)`.
        lost: Travel that each disturbed wheel lost in each sample [m], in the order of `WHEELS`, `(N, 4)`.
        nis: Normalised innovation squared of each sample, 3 degrees of freedom, shape `(N,)`; nan where
            nothing was compared.
        disturbances: Disturbances that cost 0.7 mm or more, in order of time.
        slow: Systematic errors of the encoders, as known at the end of the recording.
        findings: What seems wrong at the end of the recording.
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
    """A recording as the compiled loops take it.

    Attributes:
        counts: Counts in the order of `CHANNELS`, shape `(N, 7)`.
        present: Whether each count was read, shape `(N, 7)`.
        fixes: Absolute poses in order of time, `(K,)` records of `Fix`; the loops fill their gains.
    """

    counts: IntArray
    present: NDArray[np.bool_]
    fixes: Record


class Trace(NamedTuple):
    """What the filter gives at every sample, and what the smoother needs to run a part of it again.

    Attributes:
        poses: Poses of truck a and b [m, m, rad], shape `(2, N, 3)`.
        sigmas: Their standard deviations, shape `(2, N, 3)`.
        lost: Travel that each wheel lost [m], shape `(N, 4)`.
        alert: Travel for which each wheel stays distrusted [m], shape `(N, 4)`.
        nis: Normalised innovation squared, shape `(N,)`.
        means: First six states, shape `(N, 6)`.
        marks: The filter's state before each block of `BLOCK` samples, `(N / BLOCK,)` of `FilterState`.
        filter_marks: The open filters before each block, `(N / BLOCK, H)` records of `OpenFilter`.
        moves: Step to the mixture, each time that it was mixed, see `move_to_mixture`, shape `(D, 20)`.
    """

    poses: Array
    sigmas: Array
    lost: Array
    alert: Array
    nis: Array
    means: Array
    marks: Record
    filter_marks: Record
    moves: Array


@dataclass(frozen=True, slots=True)
class ForwardRun:
    """A run of the filter over a recording.

    Attributes:
        estimate: What the filter gives live at every sample.
        settings: The filter's settings, one record `(1,)` of `FilterSettings`.
        table: The recording.
        trace: What was kept of the run.
        last: The state after the last sample, one record `(1,)`.
        filters: The open filters after it, records `(H,)`.
    """

    estimate: Estimate
    settings: Record
    table: Table
    trace: Trace
    last: Record
    filters: Record


@compiled_without_lock
def trace_filter(settings: Record, states: Record, filters: Record, table: Table, trace: Trace) -> None:
    """Run the filter over all samples, and fill the trace.

    `states` `(1,)` and `filters` `(H,)` are changed to those after the last sample.
    """
    state, following = states[0], 0
    for sample in range(len(table.counts)):
        if sample % BLOCK == 0:
            trace.marks[sample // BLOCK] = state
            for hypothesis in range(BANK):
                trace.filter_marks[sample // BLOCK, hypothesis] = filters[hypothesis]
        advance(settings[0], state, filters, table.counts[sample], table.present[sample], trace.moves)
        following = apply_fixes(settings[0], state, filters, table.fixes, sample, following, trace.moves)
        for truck in range(2):
            look(state.mean, state.known, truck, trace.poses[truck, sample], trace.sigmas[truck, sample])
        if not state.placed:
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
    noise: FilterNoise | None,
    prior: Prior | None,
) -> ForwardRun:
    """Run the filter over a recording; arguments and errors are those of `estimate`."""
    check_linkage(recording)
    filter_ = Filter(recording.vehicle, noise, prior)
    begun = filter_.start(start, sigma)
    state, filters = begun.record.copy(), begun.filters.copy()
    table = Table(*table_of(recording), fix_records(recording, fixes))
    count, decisions = len(recording), len(recording) + 2 * len(table.fixes)
    blocks = -(-count // BLOCK)
    trace = Trace(
        np.empty((2, count, 3)),
        np.empty((2, count, 3)),
        np.empty((count, 4)),
        np.empty((count, 4)),
        np.empty(count),
        np.empty((count, POSE)),
        np.zeros(blocks, layout(FilterState)),
        np.zeros((blocks, BANK), filters.dtype),
        np.empty((decisions, STATES + 1)),
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
        slow_parameters(state["mean"][0], state["known"][0]),
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
    """Return what the filter gives live at every sample of a recording.

    Args:
        recording: Recording of a robot with two trucks.
        start: Pose of truck a at the first sample [m, m, rad], shape `(3,)`.
        sigma: Standard deviations of `start` [m, m, rad], shape `(3,)`.
        fixes: Absolute poses to use, such as `recording.poses`; None for none.
        noise: Scatter of floor and encoders; `FilterNoise()` where it is None.
        prior: How well `recording.vehicle` is known; `CALIBRATED` where it is None.

    Raises:
        NoLinkageError: The robot has a single truck.
        LinkageChannelError: A channel of the linkage was never read, or stood still while it must move.
    """
    return run_forward(recording, start, sigma, fixes, noise, prior).estimate
