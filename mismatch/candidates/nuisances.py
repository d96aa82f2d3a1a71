"""What every robot and every measurement has a little of, and no effect of the library describes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.candidates.unknown import standard, wheels_roll

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.recording.response import Columns
    from omnimate.mismatch.recording.windows import Windows

DRIFT = 5e-4  # of a wheel's radius, by which tyres change while they warm up and loads shift: 0.05 %
MODES = 3  # waves over a recording, of which such a change is made
# [m, m, rad] by which cameras that agree with each other still see a pose wrongly, from place to place:
# a millimetre in a room of some metres, and what that is on a body with markers half a metre apart
FIELD = (1e-3, 1e-3, 2e-3)
# Samples by which stamps that a computer gives on arrival are late in a recording, and by which that changes
# slowly while it lasts: which message is missed is chance, and two computers' clocks wander.
LATE, WANDERING = 1.0, (0.05, 0.05)


def add_nuisances(regression: Regression) -> range:
    """Add the columns of what every robot has, each of the size of one standard deviation; return where."""
    raw = []
    for windows in regression.windows:
        offered = [*_drifts(windows), *_fields(windows)]
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
    period, phase = float(np.median(np.diff(signals.time))), np.linspace(0.0, np.pi, len(windows.ends))
    found = []
    for mode, samples in enumerate((LATE, *WANDERING)):
        late, measured = samples * period * np.cos(mode * phase), np.zeros(windows.measured.shape)
        for truck in range(len(signals.trucks)):
            first = windows.linkage + 3 * truck
            rate = np.gradient(signals.path[:, truck], signals.time, axis=0)[windows.ends]
            measured[:, first : first + 3] = -late[:, None] * rate
        found.append((np.zeros(windows.drift.shape), measured))
    return found


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
