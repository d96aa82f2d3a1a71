"""Robots, recordings and live samples for the tests of correctors and filter."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vehicle.recording import Poses
from omnimate.vehicle.sample import Sample
from omnimate.vehicle.se2 import between, compose, wrap


def with_joints(vehicle, counts_per_turn):
    """Return the robot with other joint encoders."""
    joint = {
        "counts_per_turn": float(counts_per_turn),
        "range": counts_per_turn,
        "zero": counts_per_turn // 2,
    }
    encoders = tuple(
        replace(encoder, **joint) if encoder.channel.startswith("joint") else encoder
        for encoder in vehicle.encoders
    )
    return replace(vehicle, encoders=encoders)


@pytest.fixture
def robot():
    return reference_vehicle()


@pytest.fixture
def coarse(robot):
    """The robot with the joint encoders of C 6: 360/1024 degrees."""
    return with_joints(robot, 1024)


@pytest.fixture
def fine(robot):
    """The robot with joints and link that resolve everything."""
    robot = with_joints(robot, 2**24)
    encoders = tuple(
        replace(encoder, counts_per_metre=1e8, zero=50_000_000) if encoder.channel == "link" else encoder
        for encoder in robot.encoders
    )
    return replace(robot, encoders=encoders)


def lap_errors(recording, path, truck="a"):
    """Return true minus estimated return pose of each lap `(L, 3)`, U 3.1, for a path `(N, 3)`."""
    fixes, errors = recording.poses.of(truck), []
    for lap in recording.run.laps:
        first, last = np.searchsorted(recording.time, [lap.start - 1e-6, lap.end - 1e-6])
        before = fixes.pose[np.searchsorted(fixes.time, lap.start) - 1]
        after = fixes.pose[np.searchsorted(fixes.time, lap.end)]
        error = after - compose(before, between(path[first], path[last]))
        errors.append([*error[:2], wrap(error[2])])
    return np.array(errors)


@pytest.fixture(name="lap_errors")
def _lap_errors():
    return lap_errors


def samples(recording):
    """Yield the samples of a recording as a driver would."""
    nan = (float("nan"),) * 7
    for index, time in enumerate(recording.time):
        counts, present = recording.counts[index].tolist(), recording.present[index].tolist()
        yield Sample(index, float(time), tuple(counts), tuple(present), nan, nan)


def thinned(recording, seed=1, part=0.1):
    """Return the recording with readings missing at random; a missing one repeats the one before."""
    present = np.random.default_rng(seed).random(recording.counts.shape) > part
    present[0] = True
    rows = np.maximum.accumulate(np.where(present, np.arange(len(present))[:, None], 0), axis=0)
    counts = np.take_along_axis(recording.counts, rows, axis=0)
    return replace(recording, counts=counts, present=present)


SIGMA = (0.002, 0.002, np.radians(0.2))


def noisy(poses, seed):
    """Return poses that scatter by `SIGMA`."""
    pose = poses.pose + np.random.default_rng(seed).normal(size=poses.pose.shape) * np.array(SIGMA)
    return Poses(poses.time, poses.body, pose, np.tile(SIGMA, (len(poses.time), 1)))
