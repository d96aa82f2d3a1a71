"""Update of the filter by absolute poses, live and over a recording; compiled."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated

import numpy as np

from omnimate.ipec.filter.disturbed_wheels import STUDENT_FREEDOM
from omnimate.ipec.filter.mixture import move_to_mixture
from omnimate.ipec.filter.poses import fill_pose, fill_pose_jacobian
from omnimate.ipec.filter.records import HYPOTHESIS_COUNT, STATES, FilterState, OpenFilter
from omnimate.ipec.filter.step import finish_step
from omnimate.vehicle.arcs import arc
from omnimate.vehicle.compiled import Array, IntArray, Record, compiled, layout
from omnimate.vehicle.odometry import truck_travel, wheels_of
from omnimate.vehicle.parameters import TRUCKS
from omnimate.vehicle.se2 import wrap_angle, write_composed

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from omnimate.vehicle.parameters import TruckName
    from omnimate.vehicle.recording import Poses, Recording

MIN_FIX_SIGMA = 1e-7  # [m], [rad] smallest standard deviation of a fix, so that its variance can be inverted
# [m, m, rad] Standard deviations of a fix that states none: by a tape measure or a good localisation
# (assumption).
UNSTATED_SIGMA = np.array([0.005, 0.005, 0.01])


class Fix:
    """An absolute pose, applied after the linkage reading of the last sample before it."""

    sample: int  # number of the sample after which it is applied
    truck: int  # 0 for truck a, 1 for truck b
    pose: Annotated[Array, 3]  # measured pose [m, m, rad]; nan for a coordinate that was not measured
    motion: Annotated[Array, 3]  # of the truck from the sample to the fix [m, m, rad], in its frame before it
    sigma: Annotated[Array, 3]  # standard deviations of the pose [m, m, rad]
    row: Annotated[Array, (3, 19)]  # derivative of each coordinate by the states, before the update
    gain: Annotated[Array, (HYPOTHESIS_COUNT, 3, 21)]  # of each coordinate and hypothesis, as in `OpenFilter`


def samples_at(recording: Recording, times: Array) -> IntArray:
    """Return the number of the last sample at or before each time [s], or of the first sample."""
    return np.maximum(np.searchsorted(recording.time, times, side="right") - 1, 0)


def motion_to_fixes(
    recording: Recording, truck: TruckName, times: Array, with_truck: TruckName | None = None
) -> Array:
    """Return the motion `(K, 3)` of a truck [m, m, rad] from the sample of each fix to its time [s].

    It begins where the estimate has moved to: at the last sample at or before the fix in which both wheels
    were read, and those of another truck, if they move together.
    """
    left, right, read = truck_travel(recording, truck)
    for wheel in () if with_truck is None else wheels_of(with_truck):
        read = read & recording.is_present(wheel)
    if not read.any():
        return np.zeros((len(times), 3))
    rows = np.flatnonzero(read)
    moved = rows[np.maximum(np.searchsorted(rows, samples_at(recording, times), side="right") - 1, 0)]
    gone_left, gone_right = (
        np.interp(times, recording.time[rows], wheel[rows]) - wheel[moved] for wheel in (left, right)
    )
    return arc(gone_left, gone_right, recording.vehicle.trucks[truck].wheelbase)


@compiled
def fix_at_sample(fix: Array, motion: Array, pose: Array) -> Array:
    """Return a measured pose `(3,)` taken back by the `motion` `(3,)` since the sample.

    `pose` is the estimate for the truck at the sample, whose heading turns the motion into the world frame.
    """
    ahead = np.empty(3)
    write_composed(ahead, pose, motion)
    return fix + pose[:3] - ahead


def fix_sigma(stated: ArrayLike) -> Array:
    """Return the standard deviations `(..., 3)` with which fixes are applied: `UNSTATED_SIGMA` for nan."""
    sigma = np.asarray(stated, np.float64)
    return np.maximum(np.where(np.isnan(sigma), UNSTATED_SIGMA, sigma), MIN_FIX_SIGMA)


def fix_records(recording: Recording, fixes: Poses | None) -> Record:
    """Return the fixes as `(K,)` records of `Fix` for the compiled loops, in order of time."""
    if fixes is None:
        return np.zeros(0, layout(Fix))
    known = np.flatnonzero(np.isfinite(fixes.pose).any(axis=1))
    records = np.zeros(len(known), layout(Fix))
    records["sample"] = samples_at(recording, fixes.time[known])
    records["truck"] = fixes.body[known] == "b"
    for number, (truck, other) in enumerate((TRUCKS, TRUCKS[::-1])):
        of_truck = records["truck"] == number
        if of_truck.any():
            times = fixes.time[known][of_truck]
            records["motion"][of_truck] = motion_to_fixes(recording, truck, times, other)
    records["pose"] = fixes.pose[known]
    records["sigma"] = fix_sigma(fixes.sigma[known])
    return records[np.argsort(records["sample"], kind="stable")]


@compiled
def fix_coordinate(
    state: FilterState, opened: OpenFilter, truck: int, axis: int, value: float, sigma: float, gain: Array
) -> None:
    """Update an open filter by one coordinate (x, y, heading) of an absolute pose, a scalar Kalman update.

    `value` and its standard deviation `sigma` are in [m] or [rad]; a value of nan is skipped. `gain` `(21,)`
    is filled as in `OpenFilter`, with zeros if the coordinate was skipped.
    """
    row, pose, sigmas = np.empty((3, STATES)), np.empty(3), np.empty(3)
    covariance, ahead = opened.covariance, opened.offset
    fill_pose(state.mean, covariance, truck, pose, sigmas)
    fill_pose_jacobian(state.mean, truck, row)
    offset = value - pose[axis]
    gain[:] = 0.0
    if math.isnan(offset):
        return
    if axis == 2:
        offset = wrap_angle(offset)
    for i in range(STATES):
        offset -= row[axis, i] * ahead[i]
    for i in range(STATES):
        for j in range(STATES):
            gain[i] += covariance[i, j] * row[axis, j]
    variance = sigma * sigma
    for i in range(STATES):
        variance += row[axis, i] * gain[i]
    state.score[opened.number] -= 0.5 * math.log(variance)
    state.score[opened.number] -= (
        0.5 * (STUDENT_FREEDOM + 1.0) * math.log1p(offset * offset / variance / STUDENT_FREEDOM)
    )
    gain[STATES], gain[STATES + 1] = offset / variance, 1.0 / variance
    for i in range(STATES):
        ahead[i] += gain[i] * offset / variance
        for j in range(STATES):
            covariance[i, j] -= gain[i] * gain[j] / variance


@compiled
def apply_fix(settings: Record, states: Record, filters: Record, fix: Fix, moves: Array) -> None:
    """Apply an absolute pose, of which nan is skipped; the other arguments are as in `finish_step`."""
    state = states[0]
    finish_step(settings, states, filters, moves)
    pose, sigmas = np.empty(3), np.empty(3)
    fill_pose(state.mean, state.covariance, fix.truck, pose, sigmas)
    measured = fix_at_sample(fix.pose, fix.motion, pose)
    fill_pose_jacobian(state.mean, fix.truck, fix.row)
    for hypothesis in range(HYPOTHESIS_COUNT):
        if filters[hypothesis].is_active:
            opened, gain = filters[hypothesis], fix.gain[hypothesis]
            for axis in range(3):
                fix_coordinate(state, opened, fix.truck, axis, measured[axis], fix.sigma[axis], gain[axis])
    state.fix_count += 1
    move_to_mixture(settings[0], state, filters, moves)
