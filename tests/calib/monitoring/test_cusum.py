"""The drift monitor and its false alarms."""

import math

import numpy as np
import pytest

from omnimate.calib.monitoring.cusum import (
    DriftMonitor,
    drift_monitor,
    drives_between_false_alarms,
    step,
    threshold_for,
)


def drives_to_alarm(monitor: DriftMonitor, values: np.ndarray) -> int:
    for number, value in enumerate(values, start=1):
        monitor = step(monitor, float(value))
        if monitor.alarm:
            return number
    return len(values)


def test_false_alarms_come_as_rarely_as_stated() -> None:
    """One in 100 drives on the average, though neither mean nor scatter were known; 150 monitors."""
    chance = np.random.default_rng(1)
    runs = [drives_to_alarm(drift_monitor(100.0), chance.normal(3.0, 0.2, 1000)) for _ in range(150)]
    assert np.mean(runs) == pytest.approx(100.0, rel=0.25)


def test_a_shift_is_found_soon() -> None:
    """A shift of 1.5 standard deviations after 30 healthy drives is found within 20 drives on the average."""
    chance, found = np.random.default_rng(2), []
    for _ in range(40):
        monitor = drift_monitor(1000.0)
        for value in chance.normal(0.0, 1.0, 30):
            monitor = step(monitor, value)
        found.append(drives_to_alarm(monitor, chance.normal(-1.5, 1.0, 200)))
    assert np.mean(found) < 20.0


def test_the_threshold_inverts_the_mean_run() -> None:
    """And grows with the drives that are to pass."""
    assert drives_between_false_alarms(threshold_for(500.0)) == pytest.approx(500.0)
    assert threshold_for(5000.0) > threshold_for(500.0)
    assert drives_between_false_alarms(4.0) == pytest.approx(168.0, rel=0.02)  # Siegmund; 168 is known


def test_a_wild_reading_alone_is_no_drift() -> None:
    """Nor is one that is not a number, nor the first two drives of all."""
    monitor = drift_monitor(10_000.0)
    for value in (5.0, -3.0, 1.0, 0.5, 0.7, math.nan, 1e9):
        monitor = step(monitor, value)
        assert not monitor.alarm
    assert monitor.count == 5


def test_a_shift_after_a_wild_reading_is_found_as_soon() -> None:
    """A reading 100 standard deviations away delays the alarm by less than two drives on average."""
    chance, late = np.random.default_rng(4), []
    for _ in range(40):
        healthy, worn = chance.normal(0.0, 1.0, 30), chance.normal(2.0, 1.0, 100)
        found = []
        for wild in (0.0, 100.0):
            monitor = drift_monitor(1000.0)
            for value in (*healthy[:15], wild, *healthy[15:]):
                monitor = step(monitor, float(value))
            found.append(drives_to_alarm(monitor, worn))
        late.append(found[1] - found[0])
    assert np.mean(late) < 2.0


def test_equal_readings_are_no_reason_to_divide_by_zero() -> None:
    same = drift_monitor()
    for _ in range(5):
        same = step(same, 1.0)
    assert (same.above, same.below, same.alarm) == (0.0, 0.0, False)
