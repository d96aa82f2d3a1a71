"""What every robot and every measurement has a little of, and no effect of the library describes."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.candidates.unknown import standard, wheels_roll

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.recording.response import Columns
    from omnimate.mismatch.recording.windows import Windows
    from omnimate.vehicle.se2 import Array

DRIFT = 5e-4  # of a wheel's radius, by which tyres change while they warm up and loads shift: 0.05 %
MODES = 3  # waves over a recording, of which such a change is made
# [m, m, rad] by which cameras that agree with each other still see a pose wrongly, from place to place:
# a millimetre in a room of some metres, and what that is on a body with markers half a metre apart
FIELD = (1e-3, 1e-3, 2e-3)
# Samples by which stamps that a computer gives on arrival are late in a recording, and by which that changes
# slowly while it lasts: which message is missed is chance, and two computers' clocks wander.
LATE, WANDERING = 1.0, (0.05, 0.05)

# Windows before from which the rate of a linkage is foreseen, and the time [s] by which readings may go with
# what was not foreseen of it. What a wheel's last count rounds off stands in the rate as well as in the
# reading's innovation, and a robot that steers by its linkage answers to what has shaken it: only what is
# foreseen of a rate tells of a delay, and the rest is a nuisance beside it (errors in variables by a control
# function: Hausman, Econometrica 1978; Van den Hof & Schrama, Automatica 1993, of closed loops).
BEFORE, ANSWER = 3, 0.25
SPANS = (0.0, 0.05, 0.1)  # [s] over which the rate is taken, one sample at least: as long as delays are


def add_nuisances(regression: Regression) -> range:
    """Add the columns of what every robot has, each of the size of one standard deviation; return where."""
    raw = []
    for windows in regression.windows:
        offered = [*_drifts(windows), *_fields(windows), *_answers(windows)]
        push = np.stack([column[0] for column in offered], axis=2)
        seen = np.stack([column[1] for column in offered], axis=2)
        raw.append((push, seen))
    shared = regression.extend(raw, [raw[0][0].shape[2]])[0]
    apart = regression.extend(*_of_each([_stamps(windows) for windows in regression.windows], regression))
    return range(shared.start, apart[-1].stop if apart else shared.stop)


def _of_each(columns: Sequence[list[Columns]], regression: Regression) -> tuple[list[Columns], list[int]]:
    """Return columns that act in one recording each, for all recordings, and how many there are."""
    count = sum(len(some) for some in columns)
    raw, first = [], 0
    for windows, some in zip(regression.windows, columns, strict=True):
        push = np.zeros((*windows.drift.shape, count))
        seen = np.zeros((*windows.measured.shape, count))
        for number, (own_push, own_seen) in enumerate(some, start=first):
            push[:, :, number], seen[:, :, number] = own_push, own_seen
        first += len(some)
        raw.append((push, seen))
    return raw, [count] if count else []


def _stamps(windows: Windows) -> list[Columns]:
    """Return the columns of a recording's poses that are stamped late, by a time that wanders."""
    signals = windows.signals
    if signals.poses is None:
        return []
    time, found = signals.time, []
    period = float(np.median(np.diff(time)))

    def late(when: Array, mode: int, samples: float) -> Array:
        return np.asarray(samples * period * np.cos(mode * np.pi * (when - time[0]) / (time[-1] - time[0])))

    for mode, samples in enumerate((LATE, *WANDERING)):
        measured = np.zeros(windows.measured.shape)
        for truck in range(len(signals.trucks)):
            first = windows.linkage + 3 * truck
            measured[:, first : first + 3] = windows.aged(truck, partial(late, mode=mode, samples=samples))
        found.append((np.zeros(windows.drift.shape), measured))
    return found


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
            for part in (_unforeseen(rate), grown * _unforeseen(rate)):
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
    """Return the columns of wheels whose radius changes slowly."""
    phase = np.linspace(0.0, np.pi, len(windows.signals.block))
    wheels = len(windows.signals.recording.vehicle.wheels)
    return [
        wheels_roll(windows, (wheel,), DRIFT * np.cos(mode * phase))
        for wheel in range(wheels)
        for mode in range(1, MODES + 1)
    ]


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
        x, y = standard(path[:, 0]), standard(path[:, 1])
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
