"""The loop over a recording: its marks are the filter's states, from which each block runs again alike."""

import numpy as np
import pytest

from omnimate.ipec.filter.estimate import BLOCK_SAMPLES, run_forward
from omnimate.ipec.filter.live import Filter
from omnimate.ipec.filter.records import Step
from omnimate.ipec.filter.smoothing import run_block
from omnimate.motion.paths import out_and_back
from omnimate.vcan_sim.floor import Floor, bumps_under
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.compiled import layout

ZERO = (0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def run():
    """A run over two blocks and a bit, with bumps and fixes."""
    robot = reference_vehicle()
    floor = Floor(bumps=bumps_under("b.left", 6, 1.0, 14.0))
    recording = simulate(robot, Truth(robot, floor=floor, seed=1), out_and_back(8.0, 1, link_length=1.0))
    assert 2 * BLOCK_SAMPLES < len(recording) < 4 * BLOCK_SAMPLES
    return run_forward(recording, ZERO, ZERO, recording.poses, None)


def test_there_is_a_mark_before_each_block_and_the_first_is_the_start(run):
    count = len(run.table.counts)
    assert len(run.trace.checkpoints) == -(-count // BLOCK_SAMPLES)
    start = Filter(reference_vehicle()).start().record
    assert run.trace.checkpoints[0]["mean"].tolist() == start["mean"][0].tolist()
    assert run.trace.checkpoints[0]["is_linked"] == 0


def again(run, number):
    """Return the steps of a block that runs again, the numbers of their samples, and what is behind."""
    steps, samples = np.zeros((1, BLOCK_SAMPLES), layout(Step)), np.empty(BLOCK_SAMPLES, np.int64)
    trace = run.trace._replace(
        checkpoints=run.trace.checkpoints.copy(), filter_checkpoints=run.trace.filter_checkpoints.copy()
    )
    likely = run.last["weight"][0].argmax(keepdims=True)
    kept = run_block(run.settings, (run.table, trace), number, likely, steps, samples)
    return (
        steps[0, :kept],
        samples[:kept],
        (trace.checkpoints[number], trace.filter_checkpoints[number]),
        likely,
    )


def test_each_block_runs_again_to_the_next_checkpoint(run):
    for number in range(len(run.trace.checkpoints) - 1):
        _, _, (behind, filters), likely = again(run, number)
        for name in ("mean", "counts", "mixture_count"):
            assert np.array_equal(behind[name], run.trace.checkpoints[number + 1][name])
        for name in ("offset", "covariance", "alert", "learned"):
            assert np.array_equal(
                filters[name][likely], run.trace.filter_checkpoints[number + 1][name][likely]
            )


def test_a_block_runs_again_to_the_poses_of_the_estimate(run):
    steps, samples, _, _ = again(run, 1)
    assert np.array_equal(steps["mean"][:, :2], run.estimate.pose_a[samples, :2])
