"""A whole recording through the filter: poses, their uncertainty, and which wheels were disturbed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.ipec.corrector import ORIGIN
from omnimate.ipec.filter.forward import Estimate, run_forward

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from omnimate.ipec.filter.noise import FilterNoise
    from omnimate.ipec.filter.prior import Prior
    from omnimate.vehicle.recording import Poses, Recording


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
