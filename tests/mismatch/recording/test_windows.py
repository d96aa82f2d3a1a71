"""Windows end where something was read, and know what rounding and older poses do on real sensors."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.mismatch.recording.signals import signals_of
from omnimate.mismatch.recording.windows import pushed, pushed_by_curves, windows_of


def test_no_window_ends_where_a_wheels_frame_is_missing(drive):
    """What is drawn between two frames while a robot brakes is millimetres off, and no reading."""
    recording = drive(laps=1)
    plain = windows_of(signals_of(recording))
    channel = recording.vehicle.channels.index("b.right")
    present = recording.present.copy()
    present[plain.ends[5:40], channel] = False
    lost = windows_of(signals_of(replace(recording, present=present)))
    assert present[lost.ends, channel].all()
    assert np.abs(lost.ends - plain.ends).max() <= 1


def test_a_wheel_that_stands_on_the_edge_of_a_count_is_uncertain_by_half_of_it(drive):
    recording = drive(laps=1)
    wheel = recording.vehicle.channels.index("a.left")
    plain = windows_of(signals_of(recording))
    standing = int(np.flatnonzero(plain.rolled.max(axis=1) == 0.0)[0])
    counts = recording.counts.copy()
    counts[plain.ends[standing + 1], wheel] += 1  # for one sample, and back again
    jittering = windows_of(signals_of(replace(recording, counts=counts)))
    state = 6 + 3  # of the first wheel's rounding, after two poses and three readings of the linkage
    count = recording.vehicle.metres_per_count("a.left")
    assert plain.rounding[standing, state, state] == 0.0
    assert jittering.rounding[standing, state, state] == pytest.approx(count**2 / 4.0)


def test_older_poses_lag_by_the_way_and_hold_none_of_the_noise_of_measuring(drive, watched):
    """Else a delay of poses would explain the poses' own noise (errors in variables)."""
    recording = drive(laps=1)
    late = [
        windows_of(signals_of(watched(recording, 20, sigma))).aged(0, lambda when: np.full_like(when, 0.1))
        for sigma in (1e-9, 5e-3)
    ]
    signals = signals_of(recording)
    speed = np.hypot(*signals.block.twist[:, 0, :2].T) / signals.block.period
    assert np.hypot(*late[0][:, :2].T).max() == pytest.approx(0.1 * speed.max(), rel=0.02)
    assert np.abs(late[1] - late[0])[:, :2].max() < 1e-3


def test_what_is_pushed_by_curves_is_pushed_by_each_though_the_first_and_last_samples_miss_a_wheel(drive):
    recording = drive()
    present = recording.present.copy()
    present[[0, 1, -1], 0] = False
    windows = windows_of(signals_of(replace(recording, present=present)))
    steps = len(windows.signals.block)
    assert windows.ends[-1] < steps
    chance = np.random.default_rng(3)
    twist, curves = chance.normal(size=(steps, 2, 3)), chance.normal(size=(steps, 2))
    together = pushed_by_curves(windows.signals, windows.ends, twist, curves)
    some = slice(windows.ends[0], windows.ends[-1])
    for number, curve in enumerate(curves.T):
        alone = pushed(windows.signals, windows.ends, (twist * curve[:, None, None])[some])
        np.testing.assert_allclose(together[:, :, number], alone, atol=1e-12)
