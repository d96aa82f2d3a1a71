"""What is exported of a drive: odometry from its first pose, IPEC where there is a linkage, and events."""

from dataclasses import replace

import numpy as np

from omnimate.files.exporters.drive import drive_of
from omnimate.files.logs.recording_to_frames import frames_of_recording
from omnimate.ipec.corrector import correct
from omnimate.vehicle.odometry import dead_reckon


def test_odometry_goes_through_the_first_whole_pose_and_ipec_starts_where_it_does(drive):
    paths = {path.name: path.pose for path in drive.paths}
    recording, poses = drive.recording, drive.recording.poses
    assert list(paths) == ["odometry_a", "odometry_b", "ipec_a", "ipec_b"]
    start = paths["odometry_a"][0]
    np.testing.assert_array_equal(paths["odometry_a"], dead_reckon(recording, "a", start))
    seen = np.searchsorted(recording.time, poses.time[0])
    np.testing.assert_allclose(paths["odometry_a"][seen], poses.pose[0], atol=1e-9)
    np.testing.assert_array_equal(paths["ipec_b"], correct(recording, start).pose_b)


def test_a_single_truck_has_odometry_alone(single):
    assert [path.name for path in single.paths] == ["odometry_a"]
    assert single.notes == ()


def test_a_frozen_linkage_leaves_ipec_out_and_says_so(recording):
    never = recording.present.copy()
    never[:, recording.vehicle.channels.index("joint_a")] = False
    drive = drive_of(replace(recording, present=never), frames_of_recording(recording))
    assert [path.method for path in drive.paths] == ["odometry", "odometry"]
    assert "without IPEC" in drive.notes[0]
    assert "joint_a" in drive.notes[0]


def test_events_are_gaps_laps_and_what_the_frames_say_in_order_of_time(drive):
    words = [event.what for event in drive.events]
    assert [event.time for event in drive.events] == sorted(event.time for event in drive.events)
    for part in ("lap 1 begins", "EMCY 2310h", "error frame", "gap of a.left", "lap 1 ends"):
        assert any(part in text for text in words), part
