"""The fixed-interval smoother: the best estimate of a whole recording that its encoders allow."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ipec.corrector import ORIGIN
from ipec.estimate import Estimate, estimate, fix_records
from ipec.filter import Filter
from ipec.filter_records import FilterState
from ipec.readings import table_of
from ipec.smoothing import Adjoint, mark_blocks, run_block, smooth_block
from vehicle.compiled import Array, layout, record

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ipec.filter import Noise, Prior
    from vehicle.recording import Poses, Recording

BLOCK = 1024  # samples whose steps are kept at once


def smooth(
    recording: Recording,
    start: ArrayLike = ORIGIN,
    sigma: ArrayLike = (0.0, 0.0, 0.0),
    *,
    fixes: Poses | None = None,
    noise: Noise | None = None,
    prior: Prior | None = None,
) -> Estimate:
    """Return the best estimate at every sample from all samples of a recording, before and after it.

    Arguments, result and errors are those of `ipec.estimate.estimate`, whose last pose is the same; NIS
    and slow parameters are the filter's.
    """
    forward = estimate(recording, start, sigma, fixes=fixes, noise=noise, prior=prior)
    counts, present = table_of(recording)
    filter_ = Filter(recording.vehicle, noise, prior)
    state = filter_.start(start, sigma).record.copy()
    given, count = fix_records(recording, fixes), len(counts)
    marks = np.zeros(-(-count // BLOCK), layout(FilterState))
    mark_blocks(filter_.settings, state, counts, present, given, marks, BLOCK)
    poses, sigmas, lost = np.empty((2, count, 3)), np.empty((2, count, 3)), np.zeros((count, 4))
    steps, adjoint = np.zeros(BLOCK, layout(FilterState)), record(Adjoint)
    for number in range(len(marks) - 1, -1, -1):
        first = number * BLOCK
        own = steps[: min(BLOCK, count - first)]
        run_block(filter_.settings, marks[number : number + 1], counts, present, given, own, first)
        smooth_block(own, adjoint, given, first, poses, sigmas, lost)
    return replace(forward, pose_a=poses[0], pose_b=poses[1], sigma_a=sigmas[0], sigma_b=sigmas[1], lost=lost)
