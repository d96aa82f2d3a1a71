"""Where a finding is seen: on which channels, in which laps, at which moments and places."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects.block import wheel_number
from omnimate.effects.crossing import crossing_with_loss
from omnimate.mismatch.candidates.pushes import Push
from omnimate.mismatch.diagnosis import Where
from omnimate.mismatch.recording.folds import laps_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.effects.effect import Effect
    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.recording.signals import Signals
    from omnimate.vehicle.se2 import Array

Intervals = tuple[tuple[float, float], ...]
_SHARE = 0.1  # of the strongest channel's part, from which a channel is named


def where_of(regression: Regression, part: Array, intervals: Intervals, regime: str) -> Where:
    """Return where a part (V,) of the whitened data is seen that acts in some intervals, or all the time.

    Channels are named strongest first.
    """
    names, signals = regression.windows[0].names, [windows.signals for windows in regression.windows]
    power = np.bincount(regression.channel, weights=part**2, minlength=len(names))
    order = np.argsort(-power)
    channels = (names[at] for at in order if power[at] > _SHARE * power[order[0]] and power[at] > 0.0)
    laps, places = _laps_at(intervals, signals), _places_at(intervals, signals)
    return Where(tuple(channels), intervals, regime, laps, places)


def crossings(effect: Effect, signals: Sequence[Signals]) -> Intervals:
    """Return the stretches of time in which an effect acts; none for one that acts all the time."""
    if isinstance(effect, Push):
        return ((effect.time, effect.time + effect.lasting),)
    values = effect.values()
    if "intervals" in values:
        return tuple((float(start), float(end)) for start, end in values["intervals"])
    if "time" in values:
        last = next(float(one.time[-1]) for one in signals if values["time"] <= one.time[-1])
        return ((float(values["time"]), last),)
    if "times" not in values:
        return ()
    pairs = zip(values["times"], values["lost"], strict=True)
    return tuple((time, _end(effect.component, time, lost, signals)) for time, lost in pairs)


def _end(wheel: str, time: float, lost: float, signals: Sequence[Signals]) -> float:
    """Return when a wheel is off an obstacle that costs it some way, as a stiff wheel on an edge."""
    for one in signals:
        if not one.time[0] <= time <= one.time[-1]:
            continue
        radius = 0.5 * one.recording.vehicle.wheel_diameter(wheel)  # type: ignore[arg-type]
        span = crossing_with_loss(radius, max(lost, 1e-6)).rolled
        column = wheel_number(wheel)
        first = int(np.searchsorted(one.time, time))
        rolled = np.cumsum(np.abs(one.block.travel[first:, column]))
        at = int(np.searchsorted(rolled, span))
        return float(one.time[min(first + at + 1, len(one.time) - 1)])
    return time


def _laps_at(intervals: Intervals, signals: Sequence[Signals]) -> tuple[int, ...]:
    """Return the numbers of the laps, over all recordings, in which intervals lie."""
    laps = [lap for one in signals for lap in laps_of(one.recording)]
    hit = {
        number
        for number, (start, end) in enumerate(laps)
        for first, last in intervals
        if first < end and last > start
    }
    return tuple(sorted(hit))


def _places_at(intervals: Intervals, signals: Sequence[Signals]) -> tuple[tuple[float, float], ...]:
    """Return where truck a is in the middle of each interval [m]."""
    places = []
    for start, end in intervals:
        middle = 0.5 * (start + end)
        for one in signals:
            if one.time[0] <= middle <= one.time[-1]:
                x, y = (float(np.interp(middle, one.time, one.path[:, 0, axis])) for axis in range(2))
                places.append((x, y))
    return tuple(places)
