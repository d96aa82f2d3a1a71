"""Dead reckoning: whole recordings and single samples agree, and lost samples never look like a turn."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.vehicle.errors import RecordingError
from omnimate.vehicle.file import parse_vehicle
from omnimate.vehicle.odometry import Odometer, dead_reckon
from omnimate.vehicle.recording import Recording
from tests.recordings import samples


def recording_of(vehicle, left, right, present=None):
    counts = np.zeros((len(left), len(vehicle.channels)), np.int64)
    counts[:, 0], counts[:, 1] = left, right
    if present is None:
        present = np.ones(counts.shape, bool)
    time = vehicle.bus.sync_period * np.arange(len(left), dtype=np.float64)
    return Recording(vehicle, time, counts, present)


@pytest.fixture(scope="module")
def vehicle():
    same = "start_bit = 0, bits = 32, signed = true"
    text = f"""
    truck.a = {{wheelbase = 0.34, wheel_diameter_left = 0.15, wheel_diameter_right = 0.1502}}
    bus = {{bitrate = 500000, sync_period = 0.015}}
    encoder = [
      {{channel = "a.left", node = 1, cob_id = 0x181, {same}, sign = 1, counts_per_turn = 40000}},
      {{channel = "a.right", node = 2, cob_id = 0x182, {same}, sign = -1, counts_per_turn = 4096.5}},
    ]
    """
    return parse_vehicle(text)


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_whole_recording_and_sample_by_sample_agree_to_1e_12(vehicle, seed):
    random = np.random.default_rng(seed)
    wheels = np.cumsum(random.integers(-300, 400, (2, 3000)), axis=1)
    present = np.ones((3000, 2), bool)
    present[random.integers(0, 3000, 200), random.integers(0, 2, 200)] = False
    recording = recording_of(vehicle, *wheels, present)
    whole = dead_reckon(recording, "a", (0.3, -0.2, 0.1))
    odometer = Odometer(vehicle, "a", (0.3, -0.2, 0.1))
    stepwise = np.array([odometer.step(sample) for sample in samples(recording)])
    assert np.abs(whole - stepwise).max() < 1e-12


def test_lost_samples_of_one_wheel_leave_the_path_where_it_was(vehicle):
    left, right = 100 * np.arange(200), -10 * np.arange(200)
    present = np.ones((200, 2), bool)
    present[50:120, 0] = False
    complete = dead_reckon(recording_of(vehicle, left, right), "a")
    pierced = dead_reckon(recording_of(vehicle, left, right, present), "a")
    assert np.allclose(pierced[120:], complete[120:], atol=1e-9)
    assert np.allclose(pierced[50:120], pierced[49])


def test_wheels_never_seen_together_are_an_error_that_says_where_to_look(vehicle):
    present = np.array([[True, False], [False, True]])
    with pytest.raises(RecordingError, match=r"a\.left and a\.right are never there in the same sample"):
        dead_reckon(recording_of(vehicle, [0, 1], [0, 1], present), "a")
