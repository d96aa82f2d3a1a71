"""What the robot works out on board while a drive is simulated."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.vcan_sim.onboard import odometry_of, update_odometry
from omnimate.vcan_sim.reference import reference_single, reference_vehicle
from omnimate.vehicle.odometry import Odometer
from omnimate.vehicle.parameters import CHANNELS
from omnimate.vehicle.sample import Sample

VEHICLE = reference_vehicle()
moves = st.lists(st.tuples(st.integers(-1500, 1500), st.integers(-1500, 1500)), min_size=1, max_size=30)


def samples_of(steps):
    counts = np.zeros((len(steps) + 1, len(CHANNELS)), np.int64)
    counts[1:, :2] = np.cumsum(steps, axis=0)
    return counts


@settings(max_examples=30)
@given(moves)
def test_it_dead_reckons_as_the_robots_odometer_does(steps):
    odometry, odometer = odometry_of(VEHICLE), Odometer(VEHICLE, "a")
    for number, counts in enumerate(samples_of(steps)):
        pose, _ = update_odometry(odometry[0], counts)
        believed, unknown = (True,) * len(CHANNELS), (float("nan"),) * len(CHANNELS)
        sample = Sample(number, 0.015 * number, tuple(counts.tolist()), believed, unknown, unknown)
        assert pose == pytest.approx(odometer.step(sample), abs=1e-12)


@given(st.integers(-8000, 8000), st.integers(-8000, 8000), st.integers(-5000, 5000))
def test_it_reads_joints_and_link_from_their_zeros(joint_a, joint_b, link):
    counts = np.zeros(len(CHANNELS), np.int64)
    encoders = [VEHICLE.encoder(channel) for channel in CHANNELS[4:]]
    counts[4:] = [
        encoder.zero + moved for encoder, moved in zip(encoders, (joint_a, joint_b, link), strict=True)
    ]
    _, reading = update_odometry(odometry_of(VEHICLE)[0], counts)
    scales = [encoder.scale for encoder in encoders]
    expected = [joint_a * scales[0], joint_b * scales[1], VEHICLE.linkage.length + link * scales[2]]
    assert reading == pytest.approx(expected)


def test_the_first_sample_moves_nothing_wherever_the_counters_stand():
    odometry = odometry_of(reference_single())
    pose, _ = update_odometry(odometry[0], np.full(len(CHANNELS), 123_456, np.int64))
    assert pose == (0.0, 0.0, 0.0)
