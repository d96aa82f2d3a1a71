"""A whole recording through the filter: poses, their uncertainty, and which wheels were disturbed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ipec.corrector import ORIGIN
from ipec.filter import Filter, SlowParameters, slow_parameters
from ipec.readings import table_of
from ipec.tracing import Fix, trace_filter
from vehicle.compiled import Array, Record, layout
from vehicle.parameters import WHEELS

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ipec.filter import Noise, Prior
    from vehicle.parameters import Channel
    from vehicle.recording import Poses, Recording

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
        disturbances: in order of time.
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
    """
    counts, present = table_of(recording)
    filter_ = Filter(recording.vehicle, noise, prior)
    state = filter_.start(start, sigma).record.copy()
    count = len(counts)
    poses, sigmas = np.empty((2, count, 3)), np.empty((2, count, 3))
    lost, alert, nis = np.empty((count, 4)), np.empty((count, 4)), np.empty(count)
    given = fix_records(recording, fixes)
    trace_filter(filter_.settings, state, counts, present, given, poses, sigmas, lost, alert, nis)
    return Estimate(
        recording.time,
        poses[0],
        poses[1],
        sigmas[0],
        sigmas[1],
        lost,
        nis,
        find_disturbances(recording.time, alert, lost),
        slow_parameters(state["mean"][0], np.sqrt(np.diag(state["covariance"][0]))),
    )


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
            found.append(Disturbance(wheel, float(time[first]), float(time[last]), total))
    return tuple(sorted(found, key=lambda one: one.start))
