"""Whether recordings of one robot, in order of time, say that it is time to calibrate again.

Each quantity that a healthy robot repeats has a monitor of its own (`omnimate.calib.monitoring.cusum`): the
return errors of its cw and of its ccw laps, where fixes were taken, and the wheelbases and diameter ratios
that the filter learns from a recording, where there is a linkage. All quantities share one rate of false
alarms. A large shift is reported after about five values of a quantity, a shift of two standard deviations
after ten to forty.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.monitoring.cusum import drift_monitor, stands_apart, step
from omnimate.calib.recordings import check_frozen, check_one_robot, has_fixes
from omnimate.calib.umbmark.runs import square_runs
from omnimate.ipec.filter.estimate import estimate
from omnimate.ipec.filter.prior import MONITORING_PRIOR

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from omnimate.vehicle.recording import Recording

MIN_VALUES = 6  # values of a quantity from which on a shift of it can be seen
FALSE_ALARM = 1000.0  # drives between false alarms


@dataclass(frozen=True, slots=True)
class MonitoredQuantity:
    """One quantity that a healthy robot repeats, and the result of its monitor."""

    name: str
    unit: str  # unit of the values: m, rad or 1
    values: tuple[float, ...]  # values in order of time
    highest: float  # highest sum that the monitor reached [standard deviations]
    threshold: float  # sum above which the monitor raises the alarm [standard deviations]
    since: int | None  # number of the first value after the shift, counted from 1; None without an alarm
    apart: tuple[str, ...] = ()  # sources of single values far from those before them, which hardly count

    @property
    def means(self) -> tuple[float, float]:
        """Mean of the values before the shift and mean from it on; defined only after an alarm."""
        assert self.since is not None  # the caller asks after an alarm
        return float(np.mean(self.values[: self.since - 1])), float(np.mean(self.values[self.since - 1 :]))


@dataclass(frozen=True, slots=True)
class DriftReport:
    """The monitors of all quantities over a series of recordings."""

    quantities: tuple[MonitoredQuantity, ...]  # every quantity that has at least one value
    used: int  # number of recordings since the last calibration
    left_out: int  # number of recordings from before the last calibration

    @property
    def alarms(self) -> tuple[MonitoredQuantity, ...]:
        """Quantities that have shifted, the clearest first."""
        shifted = [quantity for quantity in self.quantities if quantity.since is not None]
        return tuple(sorted(shifted, key=lambda quantity: -quantity.highest / quantity.threshold))

    @property
    def apart(self) -> tuple[str, ...]:
        """Sources of single values that stand apart and are no shift."""
        names = [name for quantity in self.quantities if quantity.since is None for name in quantity.apart]
        return tuple(dict.fromkeys(names))

    @property
    def has_enough_values(self) -> bool:
        """Whether at least one quantity has enough values to show a shift."""
        return any(len(quantity.values) >= MIN_VALUES for quantity in self.quantities)


def monitor_drift(recordings: Sequence[Recording], false_alarm: float = FALSE_ALARM) -> DriftReport:
    """Return whether recordings of one robot show that its calibration has drifted.

    Args:
        recordings: Recordings of one robot, in any order; those with other parameters than the last one in
            time are left out.
        false_alarm: Mean number of drives between false alarms of all quantities together; at least 10.

    Raises:
        CalibrationError: There are no recordings, they are of different robots, a lap has no fixes, or a
            channel is frozen.
        LinkageChannelError: A channel of the linkage was never read, or was frozen.
    """
    ordered = sorted(recordings, key=lambda recording: float(recording.time[0]))
    check_one_robot(ordered)
    used = _since_calibration(ordered)
    collected: dict[tuple[str, str], list[tuple[float, str]]] = {}
    for recording in used:
        check_frozen(recording)
        for name, unit, value, source in (*_returns(recording), *_learned(recording)):
            if math.isfinite(value):
                collected.setdefault((name, unit), []).append((value, source))
    each = false_alarm * max(1, len(collected))
    quantities = tuple(_monitor(name, unit, values, each) for (name, unit), values in collected.items())
    return DriftReport(quantities, len(used), len(ordered) - len(used))


def _since_calibration(recordings: Sequence[Recording]) -> Sequence[Recording]:
    """Return the recordings since the last change of the trucks' parameters."""
    last = recordings[-1].vehicle.trucks
    others = [number for number, recording in enumerate(recordings) if recording.vehicle.trucks != last]
    return recordings[others[-1] + 1 :] if others else recordings


def _returns(recording: Recording) -> Iterator[tuple[str, str, float, str]]:
    """Yield the return errors of the laps, where there are laps with fixes: name, unit, value and source."""
    for truck, size in recording.vehicle.trucks.items():
        if recording.run is None or not has_fixes(recording, truck):
            continue
        for run in square_runs(recording, truck):
            x, y, heading = run.return_error(size).tolist()
            what = f"of truck {truck}, {run.direction}"
            yield f"return error {what}, x", "m", x, run.source
            yield f"return error {what}, y", "m", y, run.source
            yield f"return heading {what}", "rad", heading, run.source


def _learned(recording: Recording) -> Iterator[tuple[str, str, float, str]]:
    """Yield the wheelbases and diameter ratios that the filter learns, where the robot has a linkage.

    Left out is what the filter has no information on, so that its estimate is the prior: all of a robot that
    stands, the wheelbases of one that drives straight.
    """
    if recording.vehicle.linkage is None:
        return
    learned = estimate(recording, prior=MONITORING_PRIOR)
    if np.isnan(learned.nis).all():  # no reading was used
        return
    slow = learned.slow
    for number, truck in enumerate(recording.vehicle.trucks):
        left, right = slow.wheel[2 * number : 2 * number + 2].tolist()
        what = f"of truck {truck} beside the file, by the linkage"
        if f"wheelbase of {truck}" not in learned.findings.untold:
            yield f"wheelbase {what}", "1", float(slow.wheelbase[number]), recording.source
        yield f"diameter ratio {what}", "1", right - left, recording.source


def _monitor(
    name: str, unit: str, values: Sequence[tuple[float, str]], false_alarm: float
) -> MonitoredQuantity:
    """Return the result of a monitor that gets values, each with its source, up to its first alarm."""
    monitor, highest, since = drift_monitor(false_alarm), 0.0, None
    begun = {"above": 1, "below": 1}  # the first value since each sum was zero
    apart = []
    for number, (value, source) in enumerate(values, start=1):
        if stands_apart(monitor, value):
            apart.append(source)
        monitor = step(monitor, value)
        for side in begun:
            if getattr(monitor, side) == 0.0:
                begun[side] = number + 1
        highest = max(highest, monitor.above, monitor.below)
        if monitor.alarm:
            since = begun["above" if monitor.above > monitor.below else "below"]
            break
    series = tuple(value for value, _ in values)
    return MonitoredQuantity(name, unit, series, highest, monitor.threshold, since, tuple(apart))
