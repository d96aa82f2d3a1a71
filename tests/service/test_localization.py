"""The localization of the live robot: plain odometry from the first sample, the tracker once it is loaded."""

import numpy as np
import pytest

from omnimate.service.robot.observer import LOADING_SAMPLES, Localization
from omnimate.vehicle.odometry import dead_reckon
from tests.ipec.conftest import samples

UNKNOWN = ("ipec", "filter", "sigma", "corrections", "lost")


def take(localization, sample):
    localization.locate(sample)
    localization.step(sample)


@pytest.fixture
def tracker_at_once(monkeypatch):
    """Load the tracker in the thread of the samples, so that a test knows when it is there."""
    load = Localization._load_tracker
    loading = []
    monkeypatch.setattr(Localization, "_load_tracker", lambda self, samples: loading.append((self, samples)))
    return lambda: [load(*arguments) for arguments in loading]


def test_plain_odometry_is_that_of_the_whole_recording(small_recording, tracker_at_once):
    localization = Localization(small_recording.vehicle)
    for sample in samples(small_recording):
        take(localization, sample)
    event = localization.as_event()
    for name, truck in (("plain", "a"), ("follower", "b")):
        x, y, theta = dead_reckon(small_recording, truck)[-1]
        assert [event[name][axis] for axis in ("x", "y", "theta")] == pytest.approx([x, y, theta], abs=1e-6)
    assert all(event[name] is None for name in UNKNOWN)


def test_once_the_tracker_is_loaded_it_goes_on_from_where_odometry_is(small_recording, tracker_at_once):
    localization = Localization(small_recording.vehicle)
    every = list(samples(small_recording))
    half = len(every) // 2
    for sample in every[:half]:
        take(localization, sample)
    before = localization.as_event()["plain"]
    tracker_at_once()
    take(localization, every[half])
    take(localization, every[half + 1])
    event = localization.as_event()
    assert all(event[name] is not None for name in UNKNOWN)
    for estimate in ("ipec", "filter"):
        away = [event[estimate][axis] - before[axis] for axis in ("x", "y")]
        assert np.hypot(*away) < 0.05


def test_a_tracker_is_loaded_after_a_few_complete_samples_and_only_once(small_recording, monkeypatch):
    loaded = []
    monkeypatch.setattr(Localization, "_load_tracker", lambda _self, samples: loaded.append(len(samples)))
    monkeypatch.setattr("threading.Thread.start", lambda thread: thread.run())
    localization = Localization(small_recording.vehicle)
    for sample, _ in zip(samples(small_recording), range(10 * LOADING_SAMPLES), strict=False):
        take(localization, sample)
    assert loaded == [LOADING_SAMPLES]
