"""What every robot and every measurement has a little of, and no effect of the library describes."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects import EFFECTS
from omnimate.effects.ageing import SYNC_SKEW
from omnimate.mismatch.candidates.unknown import wheels_roll
from omnimate.mismatch.recording.response import column, response

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
# foreseen of a rate tells of a delay, and the rest is a nuisance beside it (errors in variables by a control
# function: Hausman, Econometrica 1978; Van den Hof & Schrama, Automatica 1993, of closed loops).
BEFORE, ANSWER = 3, 0.25
SPANS = (0.0, 0.05, 0.1)  # [s] over which the rate is taken, one sample at least: as long as delays are


def nuisances(windows: Sequence[Windows]) -> list[Columns]:
    """Return of each recording the columns of what every robot has, each of one standard deviation.

    They are inputs (M, 3 T, C) and measurements (M + 1, R, C).
    """
    shared = [[*_drifts(single), *_gears(single), *_fields(single), *_answers(single)] for single in windows]
    stamps = [_stamps(single) for single in windows]
    first, count = len(shared[0]), len(shared[0]) + sum(map(len, stamps))
    columns = []
    for single, mine, late in zip(windows, shared, stamps, strict=True):
        push = np.zeros((*single.drift.shape, count))
        seen = np.zeros((*single.measured.shape, count))
        places = (*range(len(mine)), *range(first, first + len(late)))
        for number, (own_push, own_seen) in zip(places, (*mine, *late), strict=True):
            push[:, :, number], seen[:, :, number] = own_push, own_seen
        first += len(late)
        columns.append((push, seen))
    return columns


def drift_waves(count: int) -> Array:
    """Return waves `(count, MODES)` over a recording of which a wheel's slow change is made, as shares."""
    phase = np.linspace(0.0, np.pi, count)
    return np.asarray(DRIFT * np.cos(np.outer(phase, range(1, MODES + 1))))


def add_nuisances(regression: Regression) -> slice:
    """Add the columns of `nuisances` to a regression; return where they are."""
    columns = nuisances(regression.windows)
    return regression.extend(columns, [columns[0][0].shape[2]], keep=False)[0]


def _stamps(windows: Windows) -> list[Columns]:
    """Return the columns of a recording's poses that are stamped late, by a time that wanders."""
    signals = windows.signals
    if signals.poses is None:
        return []
    time, found = signals.time, []
    period = float(np.median(np.diff(time)))

    def late(when: Array, mode: int, samples: float) -> Array:
        return np.asarray(samples * period * np.cos(mode * np.pi * (when - time[0]) / (time[-1] - time[0])))

    wandering = MERGED if is_merged(signals) else WANDERING
    for mode, samples in enumerate((LATE, *wandering)):
        measured = np.zeros(windows.measured.shape)
        for truck in range(len(signals.trucks)):
            first = windows.linkage + 3 * truck
            measured[:, first : first + 3] = windows.aged(truck, partial(late, mode=mode, samples=samples))
        found.append((np.zeros(windows.drift.shape), measured))
    return found


def is_merged(signals: Signals) -> bool:
    """Say whether poses carry the very stamps of samples."""
    if signals.poses is None:
        return False
    number = np.arange(len(signals.time))
    at = np.rint(np.interp(signals.poses.time, signals.time, number)).astype(int)
    return bool(np.all(np.abs(signals.time[at] - signals.poses.time) < SYNC_SKEW))


def _answers(windows: Windows) -> list[Columns]:
    """Return the columns of linkage readings that go with what was not foreseen of their rate.

    They go with it by a steady time, and by one that grows.
    """
    signals, found = windows.signals, []
    grown = np.linspace(0.0, 1.0, len(windows.ends))
    time, last = signals.block.time, np.maximum(windows.ends - 1, 0)
    for channel in range(windows.linkage):
        reading = signals.block.reading[:, channel]
        for span in SPANS:
            first = np.clip(np.searchsorted(time, time[last] - span), 0, np.maximum(last - 1, 0))
            rate = (reading[last] - reading[first]) / np.maximum(time[last] - time[first], 1e-9)
            unforeseen = _unforeseen(rate)
            for part in (unforeseen, grown * unforeseen):
                measured = np.zeros(windows.measured.shape)
                measured[:, channel] = ANSWER * part
                found.append((np.zeros(windows.drift.shape), measured))
    return found


def _unforeseen(values: Array) -> Array:
    """Return what of values (M + 1,) a regression on earlier ones does not foresee."""
    padded = np.concatenate((np.zeros(BEFORE), values))
    earlier = np.stack([padded[BEFORE - late : len(padded) - late] for late in range(1, BEFORE + 1)], axis=1)
    return np.asarray(values - earlier @ np.linalg.lstsq(earlier, values)[0])


def _drifts(windows: Windows) -> list[Columns]:
    """Return the columns of wheels whose radius changes slowly: the first ones, `MODES` of each wheel."""
    waves = drift_waves(len(windows.signals.block))
    found = []
    for wheel in range(len(windows.signals.recording.vehicle.wheels)):
        push, seen = wheels_roll(windows, (wheel,), waves)
        found += [(push[:, :, mode], seen[:, :, mode]) for mode in range(MODES)]
    return found


def _gears(windows: Windows) -> list[Columns]:
    """Return the column of a play that the gears of all wheels have alike, as gears of one make do."""
    signals = windows.signals
    vehicle = signals.recording.vehicle
    plays = [
        effect
        for kind in EFFECTS
        for wheel in vehicle.wheels
        if (effect := kind.in_any_robot(wheel, vehicle)) is not None
    ]
    return [column(response(windows, ()), response(windows, plays), 1.0)]


def _fields(windows: Windows) -> list[Columns]:
    """Return the columns of poses whose error depends smoothly on place and heading.

    A field's mean slope is a scale, which a wand of known length gives; what bends stays.
    """
    signals = windows.signals
    if signals.poses is None:
        return []
    found = []
    for truck in range(len(signals.trucks)):
        first, path = windows.linkage + 3 * truck, signals.path[windows.ends, truck]
        x, y = _across(path[:, 0]), _across(path[:, 1])
        curves = (
            x**2,
            x * y,
            y**2,
            x**3,
            x**2 * y,
            x * y**2,
            y**3,
            np.cos(2.0 * path[:, 2]),
            np.sin(2.0 * path[:, 2]),
        )
        for axis, size in enumerate(FIELD):
            for curve in curves:
                measured = np.zeros(windows.measured.shape)
                measured[:, first + axis] = size * curve
                found.append((np.zeros(windows.drift.shape), measured))
    return found


def _across(place: Array) -> Array:
    """Return places from their middle, over a room's size or their own deviation: where a field is smooth."""
    away = place - place.mean()
    return np.asarray(away / max(float(away.std()), ROOM))
