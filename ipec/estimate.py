"""A whole recording through the filter: poses, their uncertainty, and which wheels were disturbed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ipec.corrector import ORIGIN
from ipec.filter import Filter, SlowParameters, slow_parameters
from ipec.filter_records import FilterState
from ipec.health import check_linkage
from ipec.readings import table_of
from ipec.tracing import BLOCK, Fix, trace_filter
from vehicle.compiled import Array, IntArray, Record, layout
from vehicle.parameters import WHEELS

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from ipec.filter import Noise, Prior
    from vehicle.parameters import Channel
    from vehicle.recording import Poses, Recording

NOTABLE = 7e-4  # [m] lost travel from which on a disturbance is told; false alarms make 0.2 mm
SMALLEST_SIGMA = 1e-7  # [m], [rad] of a fix: one that were exact would leave nothing to invert


@dataclass(frozen=True, slots=True)
class Disturbance:
    """A wheel that did not travel as far as it rolled.

    Attributes:
        wheel: its channel.
        start: when it was noticed [s].
        end: when the wheel was trusted again [s].
        lost: travel [m].
    """

    wheel: Channel
    start: float
    end: float
    lost: float


@dataclass(frozen=True, slots=True)
class Estimate:
    """The poses of both trucks at every sample of a recording, and what else is known.

    Attributes:
        time: (N,) [s].
        pose_a: (N, 3); headings are continuous.
        pose_b: (N, 3); nan until the linkage has been read.
        sigma_a: (N, 3) standard deviations.
        sigma_b: (N, 3) likewise.
        lost: (N, 4) travel that each disturbed wheel lost [m], in the order of `WHEELS`.
        nis: (N,) normalised innovation squared, 3 degrees of freedom; nan where nothing was compared.
        disturbances: those that cost 0.7 mm or more, in order of time.
        slow: what makes the encoders err, as known at the end.
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


def estimate(
    recording: Recording,
    start: ArrayLike = ORIGIN,
    sigma: ArrayLike = (0.0, 0.0, 0.0),
    *,
    fixes: Poses | None = None,
    noise: Noise | None = None,
    prior: Prior | None = None,
) -> Estimate:
    """Return what the filter gives live at every sample of a recording.

    Args:
        recording: of a robot with two trucks.
        start: pose `(3,)` of truck a at the first sample.
        sigma: its standard deviations `(3,)`.
        fixes: absolute poses to be taken, such as those of the recording; None for none.
        noise: of floor and encoders.
        prior: of what the vehicle's file says.

    Raises:
        NoLinkageError: the robot has a single truck.
        LinkageChannelError: a channel of the linkage was never read, or was frozen.
    """
    return run_forward(recording, start, sigma, fixes, noise, prior).estimate


@dataclass(frozen=True, slots=True)
class Forward:
    """A run of the filter, and what a backward run needs of it.

    Attributes:
        estimate: its result.
        settings: of the filter.
        counts: `(N, 7)`, in the order of `CHANNELS`.
        present: likewise.
        fixes: `(K,)` as the compiled loops take them.
        marks: the filter's state before each block.
    """

    estimate: Estimate
    settings: Record
    counts: IntArray
    present: NDArray[np.bool_]
    fixes: Record
    marks: Record


def run_forward(
    recording: Recording,
    start: ArrayLike,
    sigma: ArrayLike,
    fixes: Poses | None,
    noise: Noise | None,
    prior: Prior | None,
) -> Forward:
    """Run the filter over a recording; the arguments are those of `estimate`."""
    check_linkage(recording)
    counts, present = table_of(recording)
    filter_ = Filter(recording.vehicle, noise, prior)
    state = filter_.start(start, sigma).record.copy()
    count, given = len(counts), fix_records(recording, fixes)
    marks = np.zeros(-(-count // BLOCK), layout(FilterState))
    poses, sigmas = np.empty((2, count, 3)), np.empty((2, count, 3))
    lost, alert, nis = np.empty((count, 4)), np.empty((count, 4)), np.empty(count)
    trace_filter(filter_.settings, state, counts, present, given, marks, poses, sigmas, lost, alert, nis)
    found = find_disturbances(recording.time, alert, lost)
    slow = slow_parameters(state["mean"][0], np.sqrt(np.diag(state["covariance"][0])))
    result = Estimate(recording.time, poses[0], poses[1], sigmas[0], sigmas[1], lost, nis, found, slow)
    return Forward(result, filter_.settings, counts, present, given, marks)


def fix_records(recording: Recording, fixes: Poses | None) -> Record:
    """Return the fixes `(K,)` in the form that the compiled loops take."""
    if fixes is None:
        return np.zeros(0, layout(Fix))
    known = np.flatnonzero(np.isfinite(fixes.pose).any(axis=1))
    records = np.zeros(len(known), layout(Fix))
    places = np.searchsorted(recording.time, fixes.time[known], side="right") - 1
    records["sample"] = np.clip(places, 0, len(recording) - 1)
    records["truck"] = fixes.body[known] == "b"
    records["pose"] = fixes.pose[known]
    records["sigma"] = np.maximum(fixes.sigma[known], SMALLEST_SIGMA)
    return records[np.argsort(records["sample"], kind="stable")]


def find_disturbances(time: Array, alert: Array, lost: Array) -> tuple[Disturbance, ...]:
    """Return the stretches in which wheels were distrusted, from alert and lost travel `(N, 4)` each."""
    found = []
    for number, wheel in enumerate(WHEELS):
        marks = np.diff(np.concatenate(([0], alert[:, number] > 0.0, [0])).astype(np.int8))
        starts, ends = np.flatnonzero(marks > 0).tolist(), (np.flatnonzero(marks < 0) - 1).tolist()
        for first, last in zip(starts, ends, strict=True):
            total = float(lost[first : last + 1, number].sum())
            if total >= NOTABLE:
                found.append(Disturbance(wheel, float(time[first]), float(time[last]), total))
    return tuple(sorted(found, key=lambda one: one.start))
