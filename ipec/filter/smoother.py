"""The fixed-interval smoother: poses given all samples of a recording."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.ipec.corrector import ORIGIN
from omnimate.ipec.filter.adjoint import Adjoint
from omnimate.ipec.filter.estimate import BLOCK_SAMPLES, Estimate, ForwardRun, run_forward
from omnimate.ipec.filter.records import POSE, Step
from omnimate.ipec.filter.smoothing import (
    Block,
    begin_adjoint,
    interpolate_smoothed_poses,
    run_block,
    smooth_block,
)
from omnimate.vehicle.compiled import Array, layout

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from omnimate.ipec.filter.prior import Prior
    from omnimate.vehicle.recording import Poses, Recording


def smooth(
    recording: Recording,
    start: ArrayLike = ORIGIN,
    sigma: ArrayLike = (0.0, 0.0, 0.0),
    *,
    fixes: Poses | None = None,
    prior: Prior | None = None,
) -> Estimate:
    """Return the estimate at every sample given all samples of a recording.

    At the last sample it equals the filter's estimate. `nis`, `disturbances` and `slow` are the filter's.
    Arguments and errors are those of `estimate`.
    """
    run = run_forward(recording, start, sigma, fixes, prior)
    weight, trace = run.last["weight"][0], run.trace
    likely = np.flatnonzero(weight > 0.0)
    buffer = np.zeros((len(likely), BLOCK_SAMPLES), layout(Step))
    adjoints = np.zeros(len(likely), layout(Adjoint))
    for place, hypothesis in enumerate(likely.tolist()):
        begin_adjoint(run.settings[0], run.last[0], run.filters[hypothesis], adjoints[place])
    ends = np.empty(BLOCK_SAMPLES, np.int64)
    blocks: list[list[Block]] = [[] for _ in likely]
    for number in range(len(trace.checkpoints) - 1, -1, -1):
        stored = run_block(run.settings, (run.table, trace), number, likely, buffer, ends)
        for place, hypothesis in enumerate(likely.tolist()):
            block = Block(
                ends[:stored].copy(),
                np.empty((stored, 2, POSE)),
                np.empty((stored, 2, 3)),
                np.zeros((stored, 4)),
            )
            steps, adjoint = buffer[place, :stored], adjoints[place : place + 1]
            smooth_block(steps, adjoint, hypothesis, run.table.fixes, run.last, block)
            blocks[place].append(block)
    return _average([_join_blocks(run, parts[::-1]) for parts in blocks], weight[likely])


def _average(estimates: list[Estimate], weight: Array) -> Estimate:
    """Return the average of estimates under several hypotheses by their probability `(C,)`."""
    pose_a, sigma_a = _mixture_moments([(part.pose_a, part.sigma_a) for part in estimates], weight)
    pose_b, sigma_b = _mixture_moments([(part.pose_b, part.sigma_b) for part in estimates], weight)
    return replace(
        estimates[int(weight.argmax())], pose_a=pose_a, pose_b=pose_b, sigma_a=sigma_a, sigma_b=sigma_b
    )


def _mixture_moments(parts: list[tuple[Array, Array]], weight: Array) -> tuple[Array, Array]:
    """Return mean and standard deviation of weighted distributions."""
    means, sigmas = np.stack([mean for mean, _ in parts]), np.stack([sigma for _, sigma in parts])
    mean = np.tensordot(weight, means, 1)
    return mean, np.sqrt(np.tensordot(weight, sigmas**2 + (means - mean) ** 2, 1))


def _join_blocks(run: ForwardRun, blocks: list[Block]) -> Estimate:
    """Return the smoothed estimate at every sample."""
    whole = Block(*map(np.concatenate, zip(*blocks, strict=True)))
    poses, sigmas = run.trace.poses.copy(), run.trace.sigmas.copy()
    lost = np.zeros((len(run.trace.means), 4))
    lost[whole.samples] = whole.lost
    interpolate_smoothed_poses(run.trace.means, whole, poses, sigmas)
    pose_a, pose_b = poses
    sigma_a, sigma_b = sigmas
    return replace(run.estimate, pose_a=pose_a, pose_b=pose_b, sigma_a=sigma_a, sigma_b=sigma_b, lost=lost)
