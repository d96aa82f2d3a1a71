"""The smoother's compiled passes: a replay of the filter, block by block, and the adjoint backward.

The forward run stores a checkpoint at the start of each block, so that only one block of steps is in memory,
and the moves of the mixture, so that a hypothesis can be replayed without the others. The adjoint recursion
runs through the open filter; it starts from the prior of the slow states, treated as a last reading of them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from omnimate.ipec.filter.adjoint import Adjoint, undo_decay, undo_linkage, undo_step, undo_update
from omnimate.ipec.filter.estimate import BLOCK_SAMPLES, Table, Trace
from omnimate.ipec.filter.fixes import apply_fix
from omnimate.ipec.filter.forms import fill_error_transition
from omnimate.ipec.filter.poses import add_axle_angle_variance, add_nonlinear_error, fill_pose
from omnimate.ipec.filter.records import (
    FAST,
    HYPOTHESIS_COUNT,
    POSE,
    SLOW,
    STATES,
    FilterSettings,
    FilterState,
    OpenFilter,
    Step,
)
from omnimate.ipec.filter.step import finish_step, predict
from omnimate.ipec.filter.suspects import average_slow_states
from omnimate.vehicle.compiled import Array, IntArray, Record, compiled
from omnimate.vehicle.matrices import add_scaled, multiply


class Block(NamedTuple):
    """The smoothed steps of a block of samples."""

    samples: IntArray  # number of the sample of each step, `(M,)`, ascending
    moves: Array  # from the filter's states to the smoothed ones after and before each step, `(M, 2, 6)`
    sigmas: Array  # standard deviations of both trucks' poses, `(M, 2, 3)`
    lost: Array  # travel that each wheel lost in each step [m], `(M, 4)`


@compiled
def run_block(
    settings: Record,
    run: tuple[Table, Trace],
    number: int,
    hypotheses: IntArray,
    steps: Record,
    samples: IntArray,
) -> int:
    """Replay the filter over block `number` for some hypotheses, store every step, and return their number.

    `run` is the recording and its trace; the block's checkpoints are overwritten by the states after it.
    `steps` `(C, M)` is filled with the hypotheses' states at the first linkage reading, after every step and
    after fixes, `samples` with the numbers of these samples.
    """
    table, trace = run
    states, filters = trace.checkpoints[number : number + 1], trace.filter_checkpoints[number]
    state, fixes = states[0], table.fixes
    first, last = number * BLOCK_SAMPLES, min((number + 1) * BLOCK_SAMPLES, len(table.counts))
    stored = 0
    state.is_replay = 1
    for hypothesis in range(HYPOTHESIS_COUNT):
        filters[hypothesis].is_active = 0
    for hypothesis in hypotheses:
        filters[hypothesis].is_active = 1
    for sample in range(first, last):
        placed, fix_count = state.is_linked, state.fix_count
        if predict(settings, states, table.counts[sample], table.present[sample]):
            finish_step(settings, states, filters, trace.moves)
        while state.fix_count < len(fixes) and fixes[state.fix_count].sample <= sample:
            apply_fix(settings, states, filters, fixes[state.fix_count], trace.moves)
        if state.predicted or state.fix_count > fix_count or (state.is_linked and not placed):
            for place in range(len(hypotheses)):
                store_step(state, filters[hypotheses[place]], steps[place, stored])
            samples[stored] = sample
            stored += 1
    return stored


@compiled
def store_step(state: FilterState, opened: OpenFilter, step: Step) -> None:
    """Copy the fields of a step under one hypothesis."""
    step.predicted, step.decay = state.predicted, opened.decay
    step.mean[:], step.offset[:] = state.mean[:POSE], opened.offset[:POSE]
    step.covariance[:] = opened.covariance
    step.shift[:], step.step_travel[:] = state.shift, state.last_step_travel
    step.nonlinear_error = state.nonlinear_error
    step.transition[:], step.inputs[:] = state.transition, state.inputs
    step.input_variance[:] = opened.input_variance
    step.updated[:], step.gain[:] = opened.updated, opened.gain
    step.reading, step.row[:] = opened.reading, opened.row
    fill_error_transition(step.inputs, opened, step.transition)


@compiled
def begin_adjoint(settings: FilterSettings, state: FilterState, opened: OpenFilter, adjoint: Adjoint) -> None:
    """Fill the adjoint at the end of the recording with the prior of the slow states."""
    information, mean, known, _ = average_slow_states(settings, state, opened)
    add_scaled(mean, -1.0, state.mean[FAST:])
    add_scaled(mean, -1.0, opened.offset[FAST:])
    multiply(adjoint.vector[FAST:], information, mean)
    carried = np.zeros((SLOW, SLOW))
    for row in range(SLOW):
        multiply(carried[row], known, information[row])
    for row in range(SLOW):
        for column in range(SLOW):
            total = information[row, column]
            for middle in range(SLOW):
                total -= carried[row, middle] * information[column, middle]
            adjoint.information[FAST + row, FAST + column] = total


@compiled
def fill_smoothed_offset(adjoint: Adjoint, step: Step, move: Array) -> None:
    """Fill smoothed minus filtered first six states, `(6,)`: offset + P r."""
    for row in range(POSE):
        move[row] = step.offset[row]
        for column in range(STATES):
            move[row] += step.covariance[row, column] * adjoint.vector[column]


@compiled
def fill_smoothed_covariance(adjoint: Adjoint, step: Step, covariance: Array) -> None:
    """Fill the smoothed covariance `(6, 6)` of the first six states: P - P L P."""
    rows = step.covariance
    carried = np.zeros((POSE, STATES))
    for row in range(POSE):
        for middle in range(STATES):
            for column in range(STATES):
                carried[row, column] += rows[row, middle] * adjoint.information[middle, column]
    for row in range(POSE):
        for column in range(POSE):
            total = rows[row, column]
            for middle in range(STATES):
                total -= carried[row, middle] * rows[column, middle]
            covariance[row, column] = total


@compiled
def smooth_block(
    steps: Record, adjoints: Record, hypothesis: int, fixes: Record, ends: Record, block: Block
) -> None:
    """Run the adjoint backward through the steps of one block, and fill `block` except its samples.

    `adjoints` is that after the block, one record `(1,)`; changed to that before the block. `fixes` are the
    absolute poses of the whole recording with their gains, `ends` is the state at its end, a record `(1,)`.
    """
    adjoint = adjoints[0]
    mean, pose, covariance = np.empty(POSE), np.empty(3), np.empty((POSE, POSE))
    last = len(fixes) - 1
    for place in range(len(steps) - 1, -1, -1):
        step = steps[place]
        fill_smoothed_offset(adjoint, step, block.moves[place, 0])
        fill_smoothed_covariance(adjoint, step, covariance)
        for row in range(POSE):
            mean[row] = step.mean[row] + block.moves[place, 0, row]
            block.moves[place, 1, row] = block.moves[place, 0, row] + step.shift[row]
        add_axle_angle_variance(covariance, mean, ends[0].origin, ends[0].axle_variance)
        add_nonlinear_error(covariance, step.nonlinear_error)
        for truck in range(2):
            fill_pose(mean, covariance, truck, pose, block.sigmas[place, truck])
        while last >= 0 and fixes[last].sample > block.samples[place]:
            last -= 1
        while last >= 0 and fixes[last].sample == block.samples[place]:
            for number in range(2, -1, -1):
                undo_update(adjoint, fixes[last].row[number], fixes[last].gain[hypothesis, number])
            last -= 1
        if step.predicted:
            undo_linkage(adjoint, step)
            fill_lost_travel(adjoint, step, block.lost[place])
            undo_decay(adjoint, step.decay, step.reading)
            undo_step(adjoint, step.transition)


@compiled
def fill_lost_travel(adjoint: Adjoint, step: Step, lost: Array) -> None:
    """Fill the travel that each wheel lost in one step [m] `(4,)`: Q G' r against the travel."""
    for wheel in range(4):
        projected = 0.0
        for row in range(POSE):
            projected += step.inputs[row, wheel] * adjoint.vector[row]
        lost[wheel] = -math.copysign(step.input_variance[wheel], step.step_travel[wheel]) * projected


@compiled
def interpolate_smoothed_poses(means: Array, block: Block, poses: Array, sigmas: Array) -> None:
    """Fill the smoothed poses at every sample, interpolated between the ends of steps.

    `means` are the first six states by the filter, `(N, 6)`, and `block` holds all steps of the recording.
    Filled are the poses of truck a and b [m, m, rad] and their standard deviations, `(2, N, 3)`.
    """
    samples, moves = block.samples, block.moves
    mean, unused, none = np.empty(POSE), np.empty(3), np.zeros((POSE, POSE))
    for place in range(len(samples)):
        start = samples[place]
        end = samples[place + 1] if place + 1 < len(samples) else len(means)
        for sample in range(start, end):
            part = (sample - start) / (end - start)
            for row in range(POSE):
                after = moves[place, 0, row]
                before = moves[place + 1, 1, row] if place + 1 < len(samples) else after
                mean[row] = means[sample, row] + after + part * (before - after)
            for truck in range(2):
                fill_pose(mean, none, truck, poses[truck, sample], unused)
                for axis in range(3):
                    variance = block.sigmas[place, truck, axis] ** 2
                    next_variance = block.sigmas[min(place + 1, len(samples) - 1), truck, axis] ** 2
                    sigmas[truck, sample, axis] = math.sqrt(variance + part * (next_variance - variance))
