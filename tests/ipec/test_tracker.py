"""The tracker: live as over a recording, with what was corrected and which channels cannot be believed."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.ipec.errors import LinkageChannelError
from omnimate.ipec.tracker import Tracker, track_recording
from omnimate.motion.paths import rounded_rectangle
from omnimate.vcan_sim.floor import Floor, bumps_under
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from tests.recordings import frozen, samples


@pytest.fixture
def recording(robot):
    truth = Truth(robot, floor=Floor(bumps=bumps_under("a.left", 3, 1.0, 6.0)), seed=1)
    return simulate(robot, truth, rounded_rectangle(3.0, 2.0, ["cw"]))


def test_live_rows_and_disturbances_are_those_of_the_recording(recording):
    rows, estimate = track_recording(recording, 0.0)
    tracker, reported = Tracker(recording.vehicle), []
    for sample, row in zip(samples(recording), rows, strict=True):
        tracker.step(sample)
        reported += tracker.take_disturbances()
        live, at_once = tracker.row().as_dict(), row.as_dict()
        assert list(live) == list(at_once)
        assert list(live.values()) == pytest.approx(list(at_once.values()), abs=1e-12)
    assert [(disturbance.wheel, disturbance.start, disturbance.end) for disturbance in reported] == [
        (disturbance.wheel, disturbance.start, disturbance.end) for disturbance in estimate.disturbances
    ]
    assert [disturbance.wheel for disturbance in reported] == ["a.left"] * 3
    assert tracker.frozen() == ()


def test_rows_apart_add_up_what_was_corrected_between_them(recording):
    every, _ = track_recording(recording, 0.0)
    seldom, _ = track_recording(recording, 1.0)
    every, seldom = list(every), list(seldom)
    assert len(seldom) == pytest.approx(recording.time[-1] - recording.time[0], abs=1.0)
    for name in ("corrections", "lost"):
        total = [sum(getattr(row, name) for row in rows) for rows in (every, seldom)]
        assert total[0] == pytest.approx(total[1], abs=1e-12)
    assert np.array_equal(every[-1].filtered, seldom[-1].filtered)


def test_a_frozen_joint_is_noticed_live_and_refused_over_a_recording(recording):
    broken = frozen(recording, "joint_a")
    tracker = Tracker(broken.vehicle)
    for sample in samples(broken):
        tracker.step(sample)
    assert {found.channel for found in tracker.frozen()} == {"joint_a"}
    with pytest.raises(LinkageChannelError, match="joint_a"):
        track_recording(broken, 0.1)


def test_a_channel_that_is_not_read_is_reported_and_truck_b_is_unknown(recording):
    tracker = Tracker(recording.vehicle)
    silent = recording.present.copy()
    silent[:, 5] = False
    for sample in samples(replace(recording, present=silent)):
        tracker.step(sample)
    assert [(found.channel, found.expected) for found in tracker.frozen()] == [("joint_b", 0.0)]
    assert tracker.look().as_dict()["b_x"] is None
