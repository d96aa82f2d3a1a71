"""Whether recordings of one robot, in order of time, say that it is time to calibrate again.

Each quantity that a healthy robot repeats has a monitor of its own (`omnimate.calib.monitoring.cusum`): the
return errors of its cw and of its ccw laps, where fixes were taken, and the wheelbases and diameter ratios
that the filter learns from a recording, where there is a linkage. All quantities share one rate of false
alarms. A large shift is reported after about five values of a quantity, a shift of two standard deviations
after ten to forty.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from omnimate.calib.errors import CalibrationError
from omnimate.calib.monitoring.channels import check_frozen
from omnimate.calib.monitoring.cusum import drift_monitor, stands_apart, step
from omnimate.calib.recordings import check_one_robot, has_fixes
from omnimate.calib.umbmark.runs import square_runs
from omnimate.ipec.filter.estimate import estimate
from omnimate.ipec.filter.prior import MONITORING_PRIOR

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.vehicle.parameters import TruckName
    from omnimate.vehicle.recording import Recording

MIN_VALUES = 6  # values of a quantity from which on a shift of it can be seen
FALSE_ALARM = 1000.0  # drives between false alarms


@dataclass(frozen=True, slots=True)
class MonitoredQuantity:
    """One quantity that a healthy robot repeats, and the result of its monitor.

    Attributes:
        name: Name of the quantity.
        unit: Unit of the values: m, rad or 1.
        values: Values in order of time.
        highest: Highest sum that the monitor reached [standard deviations].
        threshold: Sum above which the monitor raises the alarm [standard deviations].
        since: Number of the first value after the shift, counted from 1; None without an alarm.
        apart: Sources of single values far from those before them, which hardly count.
    """

    name: str
    unit: str
    values: tuple[float, ...]
    highest: float
    threshold: float
    since: int | None
    apart: tuple[str, ...] = ()

    @property
    def means(self) -> tuple[float, float]:
        """Mean of the values before the shift and mean from it on; defined only after an alarm."""
        assert self.since is not None  # the caller asks after an alarm
        return float(np.mean(self.values[: self.since - 1])), float(np.mean(self.values[self.since - 1 :]))


@dataclass(frozen=True, slots=True)
class DriftReport:
    """The monitors of all quantities over a series of recordings.

    Attributes:
        quantities: Every quantity that has at least one value.
        used: Number of recordings since the last calibration.
        left_out: Number of recordings from before the last calibration.
    """

    quantities: tuple[MonitoredQuantity, ...]
    used: int
    left_out: int

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


@dataclass(slots=True)
class _Values:
    """Values and units by the name of their quantity, collected from recordings."""

    values: dict[str, list[float]] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    sources: dict[str, list[str]] = field(default_factory=dict)

    def add(self, name: str, unit: str, value: float, source: str) -> None:
        if np.isfinite(value):
            self.sources.setdefault(name, []).append(source)
            self.values.setdefault(name, []).append(float(value))
            self.units[name] = unit


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
    if not recordings:
        raise CalibrationError("drift", "no recording given")
    ordered = sorted(recordings, key=lambda recording: float(recording.time[0]))
    check_one_robot(ordered)
    used = _since_calibration(ordered)
    collected = _Values()
    for recording in used:
        check_frozen(recording)
        _add_returns(collected, recording)
        _add_learned(collected, recording)
    each = false_alarm * max(1, len(collected.values))
    quantities = [
        _monitor(name, collected.units[name], values, collected.sources[name], each)
        for name, values in collected.values.items()
    ]
    return DriftReport(tuple(quantities), len(used), len(ordered) - len(used))


def _since_calibration(recordings: Sequence[Recording]) -> Sequence[Recording]:
    """Return the recordings since the last change of the trucks' parameters."""
    last = recordings[-1].vehicle.trucks
    others = [number for number, recording in enumerate(recordings) if recording.vehicle.trucks != last]
    return recordings[others[-1] + 1 :] if others else recordings


def _add_returns(collected: _Values, recording: Recording) -> None:
    """Add the return errors of the laps, where there are laps with fixes."""
    for truck, size in recording.vehicle.trucks.items():
        if recording.run is None or not has_fixes(recording, truck):
            continue
        for run in square_runs(recording, truck):
            for axis, value in zip("xy", run.return_error(size)[:2].tolist(), strict=True):
                collected.add(
                    f"return error of truck {truck}, {run.direction}, {axis}", "m", value, run.source
                )
            heading = float(run.return_error(size)[2])
            collected.add(f"return heading of truck {truck}, {run.direction}", "rad", heading, run.source)


def _add_learned(collected: _Values, recording: Recording) -> None:
    """Add the wheelbases and diameter ratios that the filter learns, where the robot has a linkage."""
    if recording.vehicle.linkage is None:
        return
    slow = estimate(recording, prior=MONITORING_PRIOR).slow
    names: tuple[TruckName, ...] = ("a", "b")
    for number, truck in enumerate(names):
        left, right = slow.wheel[2 * number : 2 * number + 2].tolist()
        values = {"wheelbase": slow.wheelbase[number], "diameter ratio": right - left}
        for kind, value in values.items():
            name = f"{kind} of truck {truck} beside the file, by the linkage"
            collected.add(name, "1", value, recording.source)


def _monitor(
    name: str, unit: str, values: Sequence[float], sources: Sequence[str], false_alarm: float
) -> MonitoredQuantity:
    """Return the result of a monitor that gets the values one by one, up to its first alarm."""
    monitor, highest, since = drift_monitor(false_alarm), 0.0, None
    begun = {"above": 1, "below": 1}  # the first value since each sum was zero
    apart = []
    for number, (value, source) in enumerate(zip(values, sources, strict=True), start=1):
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
    return MonitoredQuantity(name, unit, tuple(values), highest, monitor.threshold, since, tuple(apart))
