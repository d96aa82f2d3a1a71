"""The last proof: the simulator itself, run over recorded wheel motion, without and with the effects.

No filter and no regression: from a measured state the trucks are driven open loop for a stretch, as the
simulator drives them, and what the sensors show at its end is held against what they did show. Effects
are those fitted to the other laps, after a way through the effects file's text.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects.block import LINKAGE
from omnimate.effects.reference_offset import truck_poses
from omnimate.mismatch.diagnosis import Change
from omnimate.mismatch.heldout import size
from omnimate.mismatch.recording.response import replayed
from omnimate.mismatch.recording.signals import expected_reading, integrated
from omnimate.vehicle.se2 import between, wrap

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.effects.effect import Effect
    from omnimate.mismatch.fit import Fitted
    from omnimate.mismatch.heldout import HeldOut
    from omnimate.mismatch.recording.signals import Signals
    from omnimate.vehicle.se2 import Array

STRETCH = 10.0  # [s] long against the sensors' resolution, short against what odometry forgets
_LEAST = 3  # stretches from which a root mean square is worth showing


def rerun(fit: Fitted, residuals: HeldOut) -> dict[str, Change]:
    """Return of each channel the open-loop mismatch, root mean square, without and with effects.

    Effects are those fitted without each fold; the robot as described has its references mounted, too.
    """
    before: dict[str, list[Array]] = {}
    after: dict[str, list[Array]] = {}
    for windows, folds in zip(fit.regression.windows, residuals.folds, strict=True):
        nominal = _missed(windows.signals, fit.mounted)
        for name, (_, missed) in nominal.items():
            before.setdefault(name, []).append(missed)
        for fold in np.unique(folds):
            fitted = _missed(windows.signals, residuals.effects[fold])
            for name, (at, missed) in fitted.items():
                of_fold = folds[np.searchsorted(windows.ends, at).clip(max=len(folds) - 1)] == fold
                after.setdefault(name, []).append(missed[of_fold])
    changes = {}
    for name, parts in before.items():
        first, last = np.concatenate(parts), np.concatenate(after[name])
        if len(first) >= _LEAST:
            changes[name] = Change(size(first), size(last))
    return changes


def _missed(signals: Signals, effects: Sequence[Effect]) -> dict[str, tuple[Array, Array]]:
    """Return of each channel the samples at which stretches end, and what the simulator misses there."""
    block, offset = replayed(signals, effects)
    missed: dict[str, tuple[Array, Array]] = {}
    count = max(1, round(float(signals.time[-1] - signals.time[0]) / STRETCH))
    edges = np.linspace(0, len(signals.time) - 1, count + 1).astype(int)
    if signals.reading.shape[1]:
        rows = np.array([_linkage(signals, block.twist, offset, *pair) for pair in itertools.pairwise(edges)])
        for number, name in enumerate(LINKAGE):
            missed[name] = edges[1:], rows[:, number]
    if signals.poses is not None:
        for number, truck in enumerate(signals.trucks):
            poses = signals.poses.of(truck)
            at = np.unique(np.searchsorted(signals.time, poses.time).clip(max=len(signals.time) - 1))
            if len(at) < 2:
                continue
            stops = (
                at if len(at) <= count else np.unique(at[np.searchsorted(at, edges).clip(max=len(at) - 1)])
            )
            path = truck_poses(effects, truck, signals.path[:, number])
            pairs = itertools.pairwise(stops)
            off = np.array([_driven(path, block.twist[:, number], *pair) for pair in pairs])
            missed[f"{truck} position"] = stops[1:], np.hypot(off[:, 0], off[:, 1])
            if np.isfinite(poses.pose[:, 2]).any():
                missed[f"{truck} heading"] = stops[1:], off[:, 2]
    return missed


def _linkage(signals: Signals, twist: Array, offset: Array, start: int, end: int) -> Array:
    """Return by how much the linkage's readings (3,) at a stretch's end are missed."""
    from_reading = signals.reading[start] - offset[start]
    lead, behind = np.zeros(3), np.array([-from_reading[2], 0.0, from_reading[1]])
    lead[2] = from_reading[0]
    paths = [integrated(twist[start:end, truck], at)[-1] for truck, at in enumerate((lead, behind))]
    expected = expected_reading(np.stack(paths)[None])[0] + offset[end]
    off = signals.reading[end] - expected
    return np.array([wrap(off[0]), wrap(off[1]), off[2]])


def _driven(path: Array, twist: Array, start: int, end: int) -> Array:
    """Return by how much a truck's pose (3,) at a stretch's end is missed, as seen from its start."""
    driven = integrated(twist[start:end], np.zeros(3))[-1]
    off = between(path[start], path[end]) - driven
    off[2] = wrap(off[2])
    return np.asarray(off)
