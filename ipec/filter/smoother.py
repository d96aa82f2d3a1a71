"""The fixed-interval smoother: the best estimate of a whole recording that its encoders allow."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.ipec.corrector import ORIGIN
from omnimate.ipec.filter.adjoint import Adjoint
from omnimate.ipec.filter.forward import Estimate, run_forward
from omnimate.ipec.filter.records import FilterState
from omnimate.ipec.filter.smoothing import run_block, smooth_block
from omnimate.ipec.filter.trace import BLOCK
from omnimate.vehicle.compiled import layout, record

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from omnimate.ipec.filter.noise import FilterNoise
    from omnimate.ipec.filter.prior import Prior
    from omnimate.vehicle.recording import Poses, Recording


def smooth(
    recording: Recording,
    start: ArrayLike = ORIGIN,
    sigma: ArrayLike = (0.0, 0.0, 0.0),
    *,
    fixes: Poses | None = None,
    noise: FilterNoise | None = None,
    prior: Prior | None = None,
) -> Estimate:
    """Return the best estimate at every sample from all samples of a recording, before and after it.

    At the last sample it equals the filter's estimate. `nis`, `disturbances` and `slow` are the filter's.

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
    run = run_forward(recording, start, sigma, fixes, noise, prior)
    count = len(recording)
    poses, sigmas, lost = np.empty((2, count, 3)), np.empty((2, count, 3)), np.zeros((count, 4))
    buffer, adjoint = np.zeros(BLOCK, layout(FilterState)), record(Adjoint)
    for number in range(len(run.marks) - 1, -1, -1):
        first = number * BLOCK
        steps, mark = buffer[: count - first], run.marks[number : number + 1]
        run_block(run.settings, mark, run.counts, run.present, run.fixes, steps, first)
        smooth_block(steps, adjoint, run.fixes, first, poses, sigmas, lost)
    return replace(
        run.estimate, pose_a=poses[0], pose_b=poses[1], sigma_a=sigmas[0], sigma_b=sigmas[1], lost=lost
    )
