"""The fixed-interval smoother: the best estimate of a whole recording that its encoders allow."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.ipec.corrector import ORIGIN
from omnimate.ipec.filter.adjoint import Adjoint
from omnimate.ipec.filter.forward import Estimate, ForwardRun, run_forward
from omnimate.ipec.filter.records import POSE, Step
from omnimate.ipec.filter.smoothing import begin_adjoints, run_block, smooth_block, spread_moves
from omnimate.ipec.filter.trace import BLOCK
from omnimate.vehicle.compiled import Array, IntArray, layout

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
    weight = run.last["weight"][0]
    likely = np.flatnonzero(weight > 0.0)
    buffer, adjoints = np.zeros((len(likely), BLOCK), layout(Step)), np.zeros(len(likely), layout(Adjoint))
    begin_adjoints(run.settings, run.last, run.filters, likely, adjoints)
    ends = np.empty(BLOCK, np.int64)
    blocks: list[list[_Block]] = [[] for _ in likely]
    for number in range(len(run.marks) - 1, -1, -1):
        first = number * BLOCK
        last, mark = min(first + BLOCK, len(recording)), run.marks[number : number + 1]
        kept = run_block(
            run.settings,
            mark,
            run.filter_marks[number],
            run.counts,
            run.present,
            run.fixes,
            run.moves,
            likely,
            buffer,
            ends,
            first,
            last,
        )
        for place, hypothesis in enumerate(likely.tolist()):
            block = _Block(
                ends[:kept].copy(), np.empty((kept, 2, POSE)), np.empty((kept, 2, 3)), np.zeros((kept, 4))
            )
            smooth_block(
                buffer[place, :kept],
                block.samples,
                adjoints[place : place + 1],
                hypothesis,
                run.fixes,
                run.last,
                block.moves,
                block.sigmas,
                block.lost,
            )
            blocks[place].append(block)
    return _averaged([_joined(run, parts[::-1]) for parts in blocks], weight[likely])


def _averaged(estimates: list[Estimate], weight: Array) -> Estimate:
    """Return the average of estimates under several hypotheses by their probability `(C,)`."""
    pose_a, sigma_a = _moments([(each.pose_a, each.sigma_a) for each in estimates], weight)
    pose_b, sigma_b = _moments([(each.pose_b, each.sigma_b) for each in estimates], weight)
    return replace(
        estimates[int(weight.argmax())], pose_a=pose_a, pose_b=pose_b, sigma_a=sigma_a, sigma_b=sigma_b
    )


def _moments(parts: list[tuple[Array, Array]], weight: Array) -> tuple[Array, Array]:
    """Return mean and standard deviation of weighted distributions."""
    means, sigmas = np.stack([mean for mean, _ in parts]), np.stack([sigma for _, sigma in parts])
    mean = np.tensordot(weight, means, 1)
    return mean, np.sqrt(np.tensordot(weight, sigmas**2 + (means - mean) ** 2, 1))


@dataclass(frozen=True, slots=True)
class _Block:
    """The smoothed steps of a block: numbers of their samples, and what `smooth_block` fills."""

    samples: IntArray
    moves: Array
    sigmas: Array
    lost: Array


def _joined(run: ForwardRun, blocks: list[_Block]) -> Estimate:
    """Return the smoothed estimate at every sample."""
    samples = np.concatenate([block.samples for block in blocks])
    moves = np.concatenate([block.moves for block in blocks])
    step_sigmas = np.concatenate([block.sigmas for block in blocks])
    poses = np.stack([run.estimate.pose_a, run.estimate.pose_b])
    sigmas = np.stack([run.estimate.sigma_a, run.estimate.sigma_b])
    lost = np.zeros((len(run.means), 4))
    lost[samples] = np.concatenate([block.lost for block in blocks])
    spread_moves(run.means, samples, moves, step_sigmas, poses, sigmas)
    return replace(
        run.estimate, pose_a=poses[0], pose_b=poses[1], sigma_a=sigmas[0], sigma_b=sigmas[1], lost=lost
    )
