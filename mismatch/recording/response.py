"""The response of the robot to effects: a replay of the recorded wheel motion with them."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects.ageing import AgedSamples
from omnimate.effects.reference_offset import ReferenceOffset
from omnimate.effects.stages import replay
from omnimate.mismatch.recording.signals import about
from omnimate.mismatch.recording.windows import pushed

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from omnimate.effects.block import Block
    from omnimate.effects.effect import Effect
    from omnimate.mismatch.recording.signals import Signals
    from omnimate.mismatch.recording.windows import Windows
    from omnimate.vehicle.se2 import Array

Columns = tuple["Array", "Array"]  # C columns: inputs `(M, 3 T, C)` and measurements `(M + 1, R, C)`


def replayed(signals: Signals, effects: Sequence[Effect]) -> tuple[Block, Array]:
    """Return the recording's steps with effects acting, and errors `(N, 3)` of the linkage's readings."""
    block = replay(signals.block, effects)
    error = block.reading - signals.block.reading
    return block, np.concatenate((error[:1], error))


def relinearised(signals: Signals, effects: Sequence[Effect]) -> Signals:
    """Return a recording's signals about the trajectory of a robot with effects."""
    for _ in range(2 if effects else 0):
        block, errors = replayed(signals, effects)
        signals = about(signals, errors, block.twist)
    return signals


def response(windows: Windows, effects: Sequence[Effect]) -> Columns:
    """Return the response of one recording to effects, relative to the nominal robot, as a single column.

    Its inputs are the difference of the robot's motion to the trajectory, and its measurements their errors.
    """
    signals = windows.signals
    block, errors = replayed(signals, effects)
    extra = block.twist - signals.block.twist
    extra = extra[windows.ends[0] : windows.ends[-1]]
    inputs = windows.drift + (pushed(signals, windows.ends, extra) if np.any(extra) else 0.0)
    offset = np.zeros(windows.measured.shape)
    if windows.linkage:
        offset[:, :3] = errors[windows.ends]
    for number, truck in enumerate(signals.trucks):
        pose = windows.pose_rows(number)
        path = signals.path[windows.ends, number]
        for effect in effects:
            if isinstance(effect, AgedSamples) and effect.acts_at() == "poses":
                offset[:, pose] += windows.aged(number, partial(_age, effect, signals.time[0]))
            elif isinstance(effect, ReferenceOffset) and effect.component == truck:
                offset[:, pose] += path - effect.truck(path)  # the path follows the measured reference
    return inputs[..., None], offset[..., None]


def _age(effect: AgedSamples, start: float, time: Array) -> Array:
    return effect.age(time, start)


def joined(parts: Iterable[Columns]) -> Columns:
    """Return columns of one recording side by side."""
    inputs, measured = zip(*parts, strict=True)
    return np.concatenate(inputs, axis=2), np.concatenate(measured, axis=2)


def moved_columns(windows: Windows, inputs: Array) -> Columns:
    """Return the columns of inputs `(M, 3 T, C)` that no sensor misreads."""
    return inputs, np.zeros((*windows.measured.shape, inputs.shape[2]))


def misread_columns(windows: Windows, measured: Array) -> Columns:
    """Return the columns of errors of measurements `(M + 1, R, C)` that do not move the robot."""
    return np.zeros((*windows.drift.shape, measured.shape[2])), measured


def data(windows: Windows, base: Columns) -> Columns:
    """Return the column of the data about the response to a base."""
    inputs, offset = base
    return inputs, windows.measured[..., None] - offset


def brief_column(
    windows: Windows, base: Sequence[Effect], effect: Effect, step: float, during: tuple[float, float]
) -> Columns:
    """Return `column` of an effect that changes the motion during an interval only.

    Only the steps in which it acts, from begin to end of `during` [s], are replayed.
    """
    signals = windows.signals
    first = max(int(np.searchsorted(windows.time, during[0], side="right")) - 1, 0)
    last = int(np.searchsorted(windows.time, during[1], side="left")) + 1  # with others it may end later
    last = min(last, len(windows.ends) - 1)
    inputs = np.zeros(windows.drift.shape)
    if last > first:
        ends = windows.ends[first : last + 1]
        block = signals.block.between(int(ends[0]), int(ends[-1]))
        extra = replay(block, [*base, effect]).twist - replay(block, base).twist
        inputs[first:last] = -pushed(signals, ends, extra) / step
    return moved_columns(windows, inputs[..., None])


def column(base: Columns, changed: Columns, step: float) -> Columns:
    """Return the column of an effect: the difference to the base's response over a step of its parameter."""
    return (base[0] - changed[0]) / step, (changed[1] - base[1]) / step
