"""The fixed-interval smoother: the best estimate of a whole recording that its encoders allow."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ipec.corrector import ORIGIN
from ipec.estimate import Estimate, run_forward
from ipec.filter_records import FilterState
from ipec.smoothing import Adjoint, run_block, smooth_block
from ipec.tracing import BLOCK
from vehicle.compiled import layout, record

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ipec.filter import Noise, Prior
    from vehicle.recording import Poses, Recording


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
    run = run_forward(recording, start, sigma, fixes, noise, prior)
    count = len(recording)
    poses, sigmas, lost = np.empty((2, count, 3)), np.empty((2, count, 3)), np.zeros((count, 4))
    steps, adjoint = np.zeros(BLOCK, layout(FilterState)), record(Adjoint)
    for number in range(len(run.marks) - 1, -1, -1):
        first = number * BLOCK
        own, mark = steps[: count - first], run.marks[number : number + 1]
        run_block(run.settings, mark, run.counts, run.present, run.fixes, own, first)
        smooth_block(own, adjoint, run.fixes, first, poses, sigmas, lost)
    return replace(
        run.estimate, pose_a=poses[0], pose_b=poses[1], sigma_a=sigmas[0], sigma_b=sigmas[1], lost=lost
    )
