"""Robots and recordings for the tests of correctors and filter."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vehicle.recording import Poses
from studies.papers import linkage_numbers, robots
from tests.recordings import samples


@pytest.fixture
def robot():
    return reference_vehicle()


@pytest.fixture
def coarse(robot):
    """The robot with the joint encoders of C 6: 360/1024 degrees."""
    return robots.with_joints(robot, 1024)


@pytest.fixture
def fine():
    """The robot with joints and link that resolve everything."""
    return robots.fine()


@pytest.fixture
def lap_errors():
    return linkage_numbers.lap_errors


def thinned(recording, seed=1, part=0.1):
    """Return the recording with readings missing at random; a missing one repeats the one before."""
    present = np.random.default_rng(seed).random(recording.counts.shape) > part
    present[0] = True
    rows = np.maximum.accumulate(np.where(present, np.arange(len(present))[:, None], 0), axis=0)
    counts = np.take_along_axis(recording.counts, rows, axis=0)
    return replace(recording, counts=counts, present=present)


def followed(filter_, state, recording, fixes):
    """Yield the states of a live filter after each sample, with the fixes that were measured by then."""
    measured = [fixes.pose, fixes.sigma, *([fixes.body] if recording.vehicle.linkage else [])]
    places, following = np.searchsorted(recording.time, fixes.time, side="right") - 1, 0
    for index, sample in enumerate(samples(recording)):
        state = filter_.step(state, sample)
        while following < len(places) and places[following] <= index:
            state = filter_.fix(state, *(column[following] for column in measured))
            following += 1
        yield state
    assert following == len(places) > 1


SIGMA = (0.002, 0.002, np.radians(0.2))


def noisy(poses, seed):
    """Return poses that scatter by `SIGMA`."""
    pose = poses.pose + np.random.default_rng(seed).normal(size=poses.pose.shape) * np.array(SIGMA)
    return Poses(poses.time, poses.body, pose, np.tile(SIGMA, (len(poses.time), 1)))
