"""What every robot and every measurement has a little of, and no effect of the library describes."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects import EFFECTS
from omnimate.effects.ageing import SYNC_SKEW
from omnimate.mismatch.candidates.unknown import wheels_roll
from omnimate.mismatch.recording.response import column, joined, misread_columns, response

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.recording.response import Columns
    from omnimate.mismatch.recording.signals import Signals
    from omnimate.mismatch.recording.windows import Windows
    from omnimate.vehicle.se2 import Array

DRIFT = 5e-4  # of a wheel's radius, by which tyres change while they warm up and loads shift: 0.05 %
MODES = 3  # waves over a recording, of which such a change is made
# [m, m, rad] by which cameras that agree with each other still see a pose wrongly, from place to place:
# a millimetre in a room of some metres, and what that is on a body with markers half a metre apart
FIELD, ROOM = (1e-3, 1e-3, 2e-3), 1.0  # [m] from the middle of a room, at which it is that much
# Samples by which stamps that a computer gives on arrival are late in a recording, and by which that changes
# slowly while it lasts: which message is missed is chance, and two computers' clocks wander.
LATE, WANDERING = 1.0, (0.05, 0.05)
# The same where poses carry the very stamps of samples: no camera looks whenever a SYNC is sent, so that
# somebody has laid one file along another, begin and end, to about a sample; what rates the clocks had is not
# known any more.
MERGED = (1.0, 0.25)

# Windows before from which the rate of a linkage is foreseen, and the time [s] by which readings may go with
# what was not foreseen of it. What a wheel's last count rounds off stands in the rate as well as in the
# reading's innovation, and a robot that steers by its linkage answers to what has shaken it: only what is
# foreseen of a rate shows a delay, and the rest is a nuisance (errors in variables by a control
# function: Hausman, Econometrica 1978; Van den Hof & Schrama, Automatica 1993, of closed loops).
BEFORE, ANSWER = 3, 0.25
SPANS = (0.0, 0.05, 0.1)  # [s] over which the rate is taken, one sample at least: as long as delays are


def nuisances(windows: Sequence[Windows]) -> list[Columns]:
    """Return of each recording the columns of what every robot has, each of one standard deviation.

    A recording's late stamps have columns of their own; all else is shared.
    """
    stamps, columns = [_stamps(model) for model in windows], []
    has_poses = any(model.signals.poses is not None for model in windows)
    for number, model in enumerate(windows):
        late = [
            stamp if at == number else np.zeros((*model.measured.shape, stamp.shape[2]))
            for at, stamp in enumerate(stamps)
        ]
        fields = [_fields(model)] if has_poses else []  # where no pose was measured they are zeros, whitened
        misread = np.concatenate([*fields, _answers(model), *late], axis=2)
        columns.append(joined([_drifts(model), _gears(model), misread_columns(model, misread)]))
    return columns


def drift_waves(count: int) -> Array:
    """Return waves `(count, MODES)` over a recording of which a wheel's slow change is made, as shares."""
    phase = np.linspace(0.0, np.pi, count)
    return np.asarray(DRIFT * np.cos(np.outer(phase, range(1, MODES + 1))))


def add_nuisances(regression: Regression) -> slice:
    """Add the columns of `nuisances` to a regression; return where they are."""
    columns = nuisances(regression.windows)
    return regression.extend(columns, [columns[0][0].shape[2]], keep=False)[0]


def _stamps(windows: Windows) -> Array:
    """Return the errors `(M + 1, R, C)` of poses that are stamped late, by a time that wanders."""
    signals = windows.signals
    if signals.poses is None:
        return np.zeros((*windows.measured.shape, 0))
    time = signals.time
    period = float(np.median(np.diff(time)))

    def late(when: Array, mode: int, samples: float) -> Array:
        return np.asarray(samples * period * np.cos(mode * np.pi * (when - time[0]) / (time[-1] - time[0])))

    wandering = MERGED if is_merged(signals) else WANDERING
    measured = np.zeros((*windows.measured.shape, 1 + len(wandering)))
    for mode, samples in enumerate((LATE, *wandering)):
        for truck in range(len(signals.trucks)):
            error = windows.aged(truck, partial(late, mode=mode, samples=samples))
            measured[:, windows.pose_rows(truck), mode] = error
    return measured


def is_merged(signals: Signals) -> bool:
    """Say whether poses carry the very stamps of samples."""
    if signals.poses is None:
        return False
    number = np.arange(len(signals.time))
    at = np.rint(np.interp(signals.poses.time, signals.time, number)).astype(int)
    return bool(np.all(np.abs(signals.time[at] - signals.poses.time) < SYNC_SKEW))


def _answers(windows: Windows) -> Array:
    """Return the errors `(M + 1, R, C)` of linkage readings that go with what was not foreseen of their rate.

    They go with it by a steady time, and by one that grows.
    """
    block, last = windows.signals.block, np.maximum(windows.ends - 1, 0)
    grown, time = np.linspace(0.0, 1.0, len(windows.ends)), block.time
    columns = [np.zeros((*windows.measured.shape, 0))]
    for channel in range(windows.linkage):
        reading = block.reading[:, channel]
        for span in SPANS:
            first = np.clip(np.searchsorted(time, time[last] - span), 0, np.maximum(last - 1, 0))
            rate = (reading[last] - reading[first]) / np.maximum(time[last] - time[first], 1e-9)
            unforeseen = _unforeseen(rate)
            measured = np.zeros((*windows.measured.shape, 2))
            measured[:, channel] = ANSWER * np.stack([unforeseen, grown * unforeseen], axis=1)
            columns.append(measured)
    return np.concatenate(columns, axis=2)


def _unforeseen(values: Array) -> Array:
    """Return what of values (M + 1,) a regression on earlier ones does not foresee."""
    padded = np.concatenate((np.zeros(BEFORE), values))
    earlier = np.stack([padded[BEFORE - late : len(padded) - late] for late in range(1, BEFORE + 1)], axis=1)
    return np.asarray(values - earlier @ np.linalg.lstsq(earlier, values)[0])


def _drifts(windows: Windows) -> Columns:
    """Return the columns of wheels whose radius changes slowly: the first ones, `MODES` of each wheel."""
    waves = drift_waves(len(windows.signals.block))
    wheels = range(windows.rolled.shape[1])
    return joined(wheels_roll(windows, (wheel,), waves) for wheel in wheels)


def _gears(windows: Windows) -> Columns:
    """Return the column of a play that the gears of all wheels have alike, as gears of one make do."""
    signals = windows.signals
    vehicle = signals.recording.vehicle
    plays = [
        effect
        for kind in EFFECTS
        for wheel in vehicle.wheels
        if (effect := kind.in_any_robot(wheel, vehicle)) is not None
    ]
    return column(response(windows, ()), response(windows, plays), 1.0)


def _fields(windows: Windows) -> Array:
    """Return the errors `(M + 1, R, C)` of poses that depend smoothly on place and heading.

    A field's mean slope is a scale, which a wand of known length gives; what bends stays.
    """
    columns = []
    for truck in range(len(windows.signals.trucks)):
        path = windows.signals.path[windows.ends, truck]
        x, y = _across(path[:, 0]), _across(path[:, 1])
        bends = x**2, x * y, y**2, x**3, x**2 * y, x * y**2, y**3
        curves = *bends, np.cos(2.0 * path[:, 2]), np.sin(2.0 * path[:, 2])
        for row, size in enumerate(FIELD, windows.pose_rows(truck).start):
            measured = np.zeros((*windows.measured.shape, len(curves)))
            measured[:, row] = size * np.stack(curves, axis=1)
            columns.append(measured)
    return np.concatenate(columns, axis=2)


def _across(place: Array) -> Array:
    """Return places from their middle, over a room's size or their own deviation: where a field is smooth."""
    away = place - place.mean()
    return np.asarray(away / max(float(away.std()), ROOM))
