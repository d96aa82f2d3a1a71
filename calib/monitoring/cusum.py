"""A self-starting CUSUM chart for a quantity that should be constant: when to calibrate again.

Its input is one value per drive, such as a component of the return error. Each value is standardised by the
mean and scatter of all earlier ones through Student's t, so that no reference value is needed and the false
alarm rate holds from the third drive on.
Source: Hawkins, Self-starting CUSUM charts, The Statistician (1987).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from scipy.optimize import brentq

from omnimate.calib.distributions import normal_upper_limit, student_tail

_SLACK = 0.5  # [standard deviations] half of the shift to detect: one standard deviation
_OVERSHOOT = 1.166  # Siegmund (1985), correction for the overshoot
_MAX_SCORE = 4.0  # [standard deviations] limit of a single score, against outliers (assumption)


def drives_between_false_alarms(threshold: float) -> float:
    """Return the mean number of drives between false alarms of a two-sided CUSUM, Siegmund (1985)."""
    reach = 2.0 * _SLACK * (threshold + _OVERSHOOT)
    return 0.5 * (math.exp(reach) - reach - 1.0) / (2.0 * _SLACK**2)


def threshold_for(drives: float) -> float:
    """Return the threshold that raises one false alarm in `drives` drives on average; at least 10."""
    return float(brentq(lambda threshold: drives_between_false_alarms(threshold) - drives, 0.0, 50.0))


@dataclass(frozen=True, slots=True)
class DriftMonitor:
    """State of a CUSUM chart; a calibration starts a new one."""

    threshold: float  # sum above which the monitor raises the alarm [standard deviations]
    count: int = 0  # number of values so far, without those that stand apart
    mean: float = 0.0  # mean of these values
    squares: float = 0.0  # sum of the squared deviations from the mean
    above: float = 0.0  # cumulative sum of the deviations above the mean [standard deviations]
    below: float = 0.0  # cumulative sum of the deviations below the mean [standard deviations]

    @property
    def alarm(self) -> bool:
        """Whether it is time to calibrate again."""
        return max(self.above, self.below) > self.threshold


def drift_monitor(drives: float = 1000.0) -> DriftMonitor:
    """Return a new monitor that raises one false alarm in `drives` drives on average."""
    return DriftMonitor(threshold_for(drives))


def step(monitor: DriftMonitor, value: float) -> DriftMonitor:
    """Return the monitor after one more value; a value that is not finite changes nothing."""
    if not math.isfinite(value):
        return monitor
    score = _score(monitor, value)
    above, below = max(0.0, monitor.above + score - _SLACK), max(0.0, monitor.below - score - _SLACK)
    if stands_apart(monitor, value):  # in the scatter, it would hide every shift after it
        return replace(monitor, above=above, below=below)
    count = monitor.count + 1
    mean = monitor.mean + (value - monitor.mean) / count
    squares = monitor.squares + (value - monitor.mean) * (value - mean)
    return replace(monitor, count=count, mean=mean, squares=squares, above=above, below=below)


def stands_apart(monitor: DriftMonitor, value: float) -> bool:
    """Return whether a value is more than four standard deviations from those before it."""
    return abs(_score(monitor, value)) >= _MAX_SCORE


def _score(monitor: DriftMonitor, value: float) -> float:
    """Return the distance of a value from those before it, as a standard normal deviate."""
    if monitor.count < 2 or monitor.squares <= 0.0:
        return 0.0
    sigma = math.sqrt(monitor.squares / (monitor.count - 1) * (monitor.count + 1) / monitor.count)
    ratio = (value - monitor.mean) / sigma
    deviate = normal_upper_limit(student_tail(abs(ratio), monitor.count - 1))
    return math.copysign(min(deviate, _MAX_SCORE), ratio)
