"""The filter's forward run over a whole recording, with what the smoother's backward run needs of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.ipec.filter.disturbances import Disturbance, find_disturbances
from omnimate.ipec.filter.findings import Findings, findings
from omnimate.ipec.filter.fixes import fix_records
from omnimate.ipec.filter.live import Filter
from omnimate.ipec.filter.records import BELIEFS, POSE, STATES, FilterState
from omnimate.ipec.filter.slow_parameters import SlowParameters, slow_parameters
from omnimate.ipec.filter.trace import BLOCK, trace_filter
from omnimate.ipec.linkage_check import check_linkage
from omnimate.ipec.readings import table_of
from omnimate.vehicle.compiled import Array, IntArray, Record, layout

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from omnimate.ipec.filter.noise import FilterNoise
    from omnimate.ipec.filter.prior import Prior
    from omnimate.vehicle.recording import Poses, Recording


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


@dataclass(frozen=True, slots=True)
class ForwardRun:
    """A run of the filter over a recording.

    Attributes:
        estimate: What the filter gives live at every sample.
        settings: The filter's settings, one record `(1,)` of `FilterSettings`.
        counts: Counts in the order of `CHANNELS`, shape `(N, 7)`.
        present: Whether each count was read, shape `(N, 7)`.
        fixes: Absolute poses as the compiled loops take them, `(K,)` records of `Fix`.
        marks: The filter's state before each block of `BLOCK` samples, records of `FilterState`.
        filter_marks: The open filters before each block, records `(B, H)` of `OpenFilter`.
        means: First six states at each sample, shape `(N, 6)`.
        moves: Way to what is believed, each time that it was decided, shape `(D, 20)`.
        last: The state after the last sample, one record `(1,)`.
        filters: The open filters after it, records `(H,)`.
    """

    estimate: Estimate
    settings: Record
    counts: IntArray
    present: NDArray[np.bool_]
    fixes: Record
    marks: Record
    filter_marks: Record
    means: Array
    moves: Array
    last: Record
    filters: Record


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
    counts, present = table_of(recording)
    filter_ = Filter(recording.vehicle, noise, prior)
    begun = filter_.start(start, sigma)
    state, filters = begun.record.copy(), begun.filters.copy()
    count, taken = len(counts), fix_records(recording, fixes)
    blocks = -(-count // BLOCK)
    marks, filter_marks = np.zeros(blocks, layout(FilterState)), np.zeros((blocks, BELIEFS), filters.dtype)
    poses, sigmas = np.empty((2, count, 3)), np.empty((2, count, 3))
    lost, alert, nis = np.empty((count, 4)), np.empty((count, 4)), np.empty(count)
    means, moves = np.empty((count, POSE)), np.empty((count + 2 * len(taken), STATES + 1))
    trace_filter(
        filter_.settings,
        state,
        filters,
        counts,
        present,
        taken,
        marks,
        filter_marks,
        poses,
        sigmas,
        lost,
        alert,
        nis,
        means,
        moves,
    )
    disturbances = find_disturbances(recording.time, alert, lost)
    slow = slow_parameters(state["mean"][0], state["known"][0])
    said = findings(filter_.settings, state, filters)
    result = Estimate(
        recording.time, poses[0], poses[1], sigmas[0], sigmas[1], lost, nis, disturbances, slow, said
    )
    return ForwardRun(
        result, filter_.settings, counts, present, taken, marks, filter_marks, means, moves, state, filters
    )
