"""What every robot and every measurement has a little of, and no effect of the library describes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.candidates.unknown import wheels_roll

if TYPE_CHECKING:
    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.recording.response import Columns
    from omnimate.mismatch.recording.windows import Windows

DRIFT = 5e-4  # of a wheel's radius, by which tyres change while they warm up and loads shift: 0.05 %
MODES = 3  # waves over a recording, of which such a change is made
PLACE = 0.01  # [m] by which markers are not over the middle of the axle


def add_nuisances(regression: Regression) -> range:
    """Add the columns of what every robot has, each of the size of one standard deviation; return where."""
    raw = []
    for windows in regression.windows:
        offered = [*_drifts(windows), *_mountings(windows)]
        push = np.stack([column[0] for column in offered], axis=2)
        seen = np.stack([column[1] for column in offered], axis=2)
        raw.append((push, seen))
    place = regression.extend(raw, [raw[0][0].shape[2]])[0]
    return range(place.start, place.stop)


def _drifts(windows: Windows) -> list[Columns]:
    """Return the columns of wheels whose radius changes slowly."""
    phase = np.linspace(0.0, np.pi, len(windows.signals.block))
    wheels = len(windows.signals.recording.vehicle.wheels)
    return [
        wheels_roll(windows, (wheel,), DRIFT * np.cos(mode * phase))
        for wheel in range(wheels)
        for mode in range(1, MODES + 1)
    ]


def _mountings(windows: Windows) -> list[Columns]:
    """Return the columns of markers that are not where they should be on their truck."""
    if windows.signals.poses is None:
        return []
    found = []
    for truck in range(len(windows.signals.trucks)):
        first, heading = windows.linkage + 3 * truck, windows.signals.path[windows.ends, truck, 2]
        ahead = np.stack([np.cos(heading), np.sin(heading)], axis=1)
        for along in (ahead, np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)):
            measured = np.zeros(windows.measured.shape)
            measured[:, first : first + 2] = PLACE * along
            found.append((np.zeros(windows.drift.shape), measured))
    return found
