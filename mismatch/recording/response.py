"""The robot with effects in it, driven by the wheel motion that was recorded: what it would have shown."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects.ageing import AgedSamples
from omnimate.effects.reference_offset import ReferenceOffset
from omnimate.effects.stages import replay
from omnimate.mismatch.recording.signals import about
from omnimate.mismatch.recording.windows import pushed

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.effects.block import Block
    from omnimate.effects.effect import Effect
    from omnimate.mismatch.recording.signals import Signals
    from omnimate.mismatch.recording.windows import Windows
    from omnimate.vehicle.se2 import Array

Columns = tuple["Array", "Array"]


@dataclass(frozen=True, slots=True)
class Response:
    """What a set of effects does to one recording.

    Attributes:
        inputs: (M, 3 T) what the robot does otherwise than the trajectory.
        offset: (M + 1, R) what its sensors show beyond what is there.
    """

    inputs: Array
    offset: Array


def replayed(signals: Signals, effects: Sequence[Effect]) -> Block:
    """Return the recording's steps with effects in them."""
    return replay(signals.block, effects)


def relinearised(signals: Signals, effects: Sequence[Effect]) -> Signals:
    """Return a recording's signals about the trajectory of a robot with effects."""
    for _ in range(2 if effects else 0):
        block = replayed(signals, effects)
        shown = block.reading - signals.block.reading
        offset = np.concatenate((shown[:1], shown)) if shown.shape[1] else 0.0
        signals = about(signals, offset, block.twist)
    return signals


def response(windows: Windows, effects: Sequence[Effect]) -> Response:
    """Return what effects do to one recording, beyond the nominal robot."""
    signals = windows.signals
    block = replayed(signals, effects)
    more = block.twist - signals.block.twist
    inputs = windows.drift + (pushed(signals, windows.ends, more) if np.any(more) else 0.0)
    offset = np.zeros(windows.measured.shape)
    if windows.linkage:
        before = np.maximum(windows.ends - 1, 0)  # a step's reading is that at its end
        offset[:, :3] = block.reading[before] - signals.block.reading[before]
    _age_poses(windows, effects, offset)
    _move_references(windows, effects, offset)
    return Response(inputs, offset)


def _age_poses(windows: Windows, effects: Sequence[Effect], offset: Array) -> None:
    """Let poses be of an earlier time than they say."""
    signals = windows.signals
    for effect in effects:
        if not isinstance(effect, AgedSamples) or effect.acts_at() != "poses":
            continue
        for truck in range(len(signals.trucks)):
            own = slice(windows.linkage + 3 * truck, windows.linkage + 3 * truck + 3)
            offset[:, own] += windows.aged(truck, partial(_age, effect, signals.time[0]))


def _age(effect: AgedSamples, start: float, when: Array) -> Array:
    return effect.age(when, start)


def _move_references(windows: Windows, effects: Sequence[Effect], offset: Array) -> None:
    """Let poses be those of references that are mounted elsewhere on their trucks."""
    signals = windows.signals
    for effect in effects:
        if isinstance(effect, ReferenceOffset) and effect.component in signals.trucks:
            truck = signals.trucks.index(effect.component)
            own = slice(windows.linkage + 3 * truck, windows.linkage + 3 * truck + 3)
            path = signals.path[windows.ends, truck]
            offset[:, own] += path - effect.truck(path)  # the path is drawn to what was measured


def data(windows: Windows, base: Response) -> Columns:
    """Return the data's column: inputs `(M, 3 T)` and measurements `(M + 1, R)`, about a base of effects."""
    return base.inputs, windows.measured - base.offset


def brief_column(
    windows: Windows, base: Sequence[Effect], effect: Effect, step: float, during: tuple[float, float]
) -> Columns:
    """Return the column of an effect that changes the motion for some time only, as `column` does.

    Only the steps in which it acts are replayed.

    Args:
        windows: Of the recording.
        base: Effects beside which it acts.
        effect: Of which the column is.
        step: Of its parameter.
        during: From when to when it acts [s].
    """
    signals = windows.signals
    first = max(int(np.searchsorted(windows.time, during[0], side="right")) - 1, 0)
    last = int(np.searchsorted(windows.time, during[1], side="left")) + 1  # beside others it may end later
    last = min(last, len(windows.ends) - 1)
    inputs = np.zeros(windows.drift.shape)
    if last > first:
        ends = windows.ends[first : last + 1]
        block = signals.block.between(int(ends[0]), int(ends[-1]))
        more = replay(block, [*base, effect]).twist - replay(block, base).twist
        inputs[first:last] = -pushed(signals, ends, more) / step
    return inputs, np.zeros(windows.measured.shape)


def column(base: Response, changed: Response, step: float) -> Columns:
    """Return an effect's column, by the difference to the base over a step of its parameter."""
    return (base.inputs - changed.inputs) / step, (changed.offset - base.offset) / step
