"""Whether recordings of one robot, in order of time, say that it is time to calibrate again.

Each kind of number that a healthy robot repeats is watched on its own by `calib.drift`: the return errors of
its cw and of its ccw laps, where fixes were taken, and the wheelbases and diameter ratios that the filter
learns from a recording, where there is a linkage. The kinds share one rate of false alarms. A large shift
is told after about five numbers of a kind, one of two standard deviations after ten to forty.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from calib.channel_guards import check_frozen
from calib.drift import drift_monitor, step
from calib.errors import CalibrationError
from calib.recordings import check_one_robot, has_fixes, square_runs
from ipec.estimate import estimate
from ipec.filter import NOMINAL

if TYPE_CHECKING:
    from collections.abc import Sequence

    from vehicle.parameters import TruckName
    from vehicle.recording import Recording

ENOUGH = 6  # numbers of one kind from which on a shift of it can be told
FALSE_ALARM = 1000.0  # drives between false alarms


@dataclass(frozen=True, slots=True)
class Watched:
    """One kind of number, and what its monitor says.

    Attributes:
        name: of the kind.
        unit: of the numbers: m, rad or 1.
        values: in order of time.
        highest: sum that the monitor reached.
        threshold: of the alarm.
        since: number of the first value after the shift, from 1 on; None without an alarm.
    """

    name: str
    unit: str
    values: tuple[float, ...]
    highest: float
    threshold: float
    since: int | None

    @property
    def means(self) -> tuple[float, float]:
        """The mean before and from the shift on; only after an alarm."""
        assert self.since is not None  # the caller asks after an alarm
        return float(np.mean(self.values[: self.since - 1])), float(np.mean(self.values[self.since - 1 :]))


@dataclass(frozen=True, slots=True)
class DriftReport:
    """What recordings say together.

    Attributes:
        watched: each kind with at least one number.
        used: recordings since the last calibration.
        left_out: recordings before it.
    """

    watched: tuple[Watched, ...]
    used: int
    left_out: int

    @property
    def alarms(self) -> tuple[Watched, ...]:
        """The kinds that have shifted, the clearest first."""
        found = [one for one in self.watched if one.since is not None]
        return tuple(sorted(found, key=lambda one: -one.highest / one.threshold))

    @property
    def tells(self) -> bool:
        """Whether some kind has numbers enough."""
        return any(len(one.values) >= ENOUGH for one in self.watched)


@dataclass(slots=True)
class _Kinds:
    """Numbers by the names of their kinds, with units, as recordings come."""

    values: dict[str, list[float]] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)

    def add(self, name: str, unit: str, value: float) -> None:
        if np.isfinite(value):
            self.values.setdefault(name, []).append(float(value))
            self.units[name] = unit


def watch_drift(recordings: Sequence[Recording], false_alarm: float = FALSE_ALARM) -> DriftReport:
    """Return what recordings of one robot say about its calibration.

    Args:
        recordings: in any order; those with other parameters than the last one in time are left out.
        false_alarm: drives between false alarms of all kinds together, on the average; 10 or more.

    Raises:
        CalibrationError: no recordings, of different robots, a lap without fixes, or a frozen channel.
        LinkageChannelError: a channel of the linkage was never read, or was frozen.
    """
    if not recordings:
        raise CalibrationError("drift", "no recording given")
    ordered = sorted(recordings, key=lambda one: float(one.time[0]))
    check_one_robot(ordered)
    used = _since_calibration(ordered)
    kinds = _Kinds()
    for recording in used:
        check_frozen(recording)
        _add_returns(kinds, recording)
        _add_learned(kinds, recording)
    each = false_alarm * max(1, len(kinds.values))
    watched = [_watch(name, kinds.units[name], values, each) for name, values in kinds.values.items()]
    return DriftReport(tuple(watched), len(used), len(ordered) - len(used))


def _since_calibration(recordings: Sequence[Recording]) -> Sequence[Recording]:
    """Return the last recordings whose trucks have one set of parameters."""
    last = recordings[-1].vehicle.trucks
    others = [number for number, one in enumerate(recordings) if one.vehicle.trucks != last]
    return recordings[others[-1] + 1 :] if others else recordings


def _add_returns(kinds: _Kinds, recording: Recording) -> None:
    """Add the return errors of the laps, where there are laps and fixes."""
    for truck, size in recording.vehicle.trucks.items():
        if recording.run is None or not has_fixes(recording, truck):
            continue
        for run in square_runs(recording, truck):
            for axis, value in zip("xy", run.return_error(size)[:2].tolist(), strict=True):
                kinds.add(f"return error of truck {truck}, {run.direction}, {axis}", "m", value)
            kinds.add(
                f"return heading of truck {truck}, {run.direction}", "rad", float(run.return_error(size)[2])
            )


def _add_learned(kinds: _Kinds, recording: Recording) -> None:
    """Add what the filter learns of wheelbases and diameters, where there is a linkage to learn from."""
    if recording.vehicle.linkage is None:
        return
    slow = estimate(recording, prior=NOMINAL).slow
    names: tuple[TruckName, ...] = ("a", "b")
    for number, truck in enumerate(names):
        left, right = slow.wheel[2 * number : 2 * number + 2].tolist()
        kinds.add(f"wheelbase of truck {truck} beside the file, by the linkage", "1", slow.wheelbase[number])
        kinds.add(f"diameter ratio of truck {truck} beside the file, by the linkage", "1", right - left)


def _watch(name: str, unit: str, values: Sequence[float], false_alarm: float) -> Watched:
    """Return what a monitor says that looks at values one by one, up to its first alarm."""
    monitor, highest, since = drift_monitor(false_alarm), 0.0, None
    begun = {"above": 1, "below": 1}  # the first value since each sum was zero
    for number, value in enumerate(values, start=1):
        monitor = step(monitor, value)
        for side in begun:
            if getattr(monitor, side) == 0.0:
                begun[side] = number + 1
        highest = max(highest, monitor.above, monitor.below)
        if monitor.alarm:
            since = begun["above" if monitor.above > monitor.below else "below"]
            break
    return Watched(name, unit, tuple(values), highest, monitor.threshold, since)
