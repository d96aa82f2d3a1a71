"""MCAP files and ROS 2 bags: the readers of mcap and rosbags find every sample, pose, event and frame."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from omnimate.files.errors import ExportError
from omnimate.files.exporters.export import export_drive, export_frames
from omnimate.files.exporters.messages import speeds
from omnimate.files.importers.rosbag.importer import read_bag
from omnimate.files.importers.rosbag.plan import plan_of_options
from omnimate.files.logs.blocks import LogStream
from omnimate.files.logs.frames import ERROR, EXTENDED, FD, REMOTE, nanoseconds
from omnimate.vehicle.arcs import arc, integrate
from tests.files.exporters.conftest import silent, written_log
from tests.files.logs.any_frames import logs

TARGETS = ("drive.mcap", "drive_bag")


def messages(path, topic):
    """The messages of a topic and the times at which they stand in the file [ns]."""
    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        wanted = [connection for connection in reader.connections if connection.topic == topic]
        if not wanted:  # for the library no connection is all of them
            return []
        return [
            (time, reader.deserialize(raw, connection.msgtype))
            for connection, time, raw in reader.messages(wanted)
        ]


def stamp_of(message):
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def yaw(turn):
    return 2.0 * math.atan2(turn.z, turn.w)


@pytest.mark.parametrize("name", TARGETS)
def test_rosbags_reads_the_poses_of_every_path(drive, tmp_path, name):
    export_drive(drive, tmp_path / name, silent)
    for path in drive.paths:
        seen = messages(tmp_path / name, f"/{path.method}/{path.truck}")
        known = np.isfinite(path.pose[:, 0])
        assert [time for time, _ in seen] == [nanoseconds(time) for time in path.time[known].tolist()]
        assert all(stamp_of(message) == time for time, message in seen)
        poses = [message.pose.pose for _, message in seen]
        xy = np.array([[pose.position.x, pose.position.y] for pose in poses])
        np.testing.assert_array_equal(xy, path.pose[known, :2])
        turned = np.array([yaw(pose.orientation) for pose in poses]) - path.pose[known, 2]
        np.testing.assert_allclose(np.cos(turned), 1.0, atol=1e-12)


@pytest.mark.parametrize("name", TARGETS)
def test_only_channels_that_were_read_stand_in_a_sample(drive, tmp_path, name):
    export_drive(drive, tmp_path / name, silent)
    states = [message for _, message in messages(tmp_path / name, "/joint_states")]
    assert len(states) == len(drive.recording)
    assert "a.left" not in states[50].name
    wheel = drive.recording.wheel_angle("a.right")
    assert [state.position[list(state.name).index("a.right")] for state in states] == wheel.tolist()


@pytest.fixture
def mcap(drive, tmp_path):
    """The drive as an MCAP file."""
    export_drive(drive, tmp_path / "drive.mcap", silent)
    return tmp_path / "drive.mcap"


def test_measured_poses_have_their_deviations_and_those_without_heading_are_points(mcap):
    whole = [message for _, message in messages(mcap, "/poses/a")]
    assert [yaw(message.pose.pose.orientation) for message in whole] == pytest.approx([0.3, 0.4])
    assert whole[0].pose.covariance[[0, 7, 35]].tolist() == pytest.approx([1e-4, 4e-4, 9e-4])
    assert not whole[1].pose.covariance.any()
    ((_, point),) = messages(mcap, "/positions/b")
    assert (point.point.x, point.point.y) == (0.1, 1.9)


def test_events_commands_and_transforms_are_there(drive, mcap):
    events = [message for _, message in messages(mcap, "/events")]
    assert [message.msg for message in events] == [event.what for event in drive.events]
    assert {message.level for message in events} == {20, 30}
    commands = [message for _, message in messages(mcap, "/commands")]
    assert commands[0].velocity.tolist() == [1.5] * 4
    ((_, first), *_) = messages(mcap, "/tf")
    assert {each.child_frame_id for each in first.transforms} <= {
        "truck_a",
        "truck_b",
        "truck_a_ipec",
        "truck_b_ipec",
    }


def test_the_mcap_library_reads_profile_schemas_and_order(mcap):
    with mcap.open("rb") as file:
        reader = make_reader(file)
        assert reader.get_header().profile == "ros2"
        rows = list(reader.iter_messages(log_time_order=False))
    assert {schema.encoding for schema, _, _ in rows} == {"ros2msg"}
    assert {channel.message_encoding for _, channel, _ in rows} == {"cdr"}
    times = [message.log_time for _, _, message in rows]
    assert times == sorted(times)


def test_what_is_exported_can_be_imported_again(drive, mcap):
    recording = drive.recording
    plan = plan_of_options(
        [f"{channel}=/joint_states:{channel}" for channel in recording.vehicle.channels], ["a=/poses/a"]
    )
    again = read_bag(mcap, plan, recording.vehicle).recording
    rows = recording.is_present("a.left")  # whose clock the importer takes
    np.testing.assert_allclose(again.time, recording.time[rows], atol=1e-6)
    for channel in recording.vehicle.channels:
        back, counts = again.channel_counts(channel), recording.channel_counts(channel)[rows]
        np.testing.assert_allclose(back - back[0], counts - counts[0], atol=1)
    np.testing.assert_allclose(again.poses.pose, recording.poses.of("a").pose, atol=1e-12)


@pytest.mark.slow
@settings(max_examples=20)
@given(rows=logs(directions=(0,)), name=st.sampled_from(TARGETS))
def test_frames_are_can_msgs_on_the_topic_of_their_interface(tmp_path_factory, rows, name):
    folder = tmp_path_factory.mktemp("frames")
    done = export_frames(written_log(folder / "can.log", rows), folder / name, silent)
    assert done.frames == len(rows)
    seen = []
    for channel in sorted({row.channel for row in rows}):
        for kind in ("can", "can_fd"):
            seen += [(kind, *pair) for pair in messages(folder / name, f"/{kind}/{channel}")]
    assert sorted(fields_of(*each) for each in seen) == sorted(fields(row) for row in rows)


def fields(row):
    """What a message says of a frame."""
    kind = "can_fd" if row.flags & FD else "can"
    flags = row.flags & (EXTENDED | ERROR | REMOTE)
    return kind, nanoseconds(row.time), row.channel, row.can_id, flags, row.length, row.data


def fields_of(kind, time, message):
    flags = message.is_extended * EXTENDED | message.is_error * ERROR
    flags |= getattr(message, "is_rtr", False) * REMOTE
    length = message.len if kind == "can_fd" else message.dlc
    data = b"" if flags & REMOTE else bytes(message.data)[:length]
    return kind, time, message.header.frame_id, message.id, flags, length, data


def test_a_time_that_ros_cannot_hold_is_refused(tmp_path):
    (tmp_path / "can.log").write_text("(2147483648.000000) can0 181#01\n")
    with pytest.raises(ExportError, match="2038"):
        export_frames(LogStream(tmp_path / "can.log"), tmp_path / "a.mcap", silent)
    assert not (tmp_path / "a.mcap").exists()


def test_a_bag_that_exists_is_not_written_over(drive, tmp_path):
    (tmp_path / "bag").mkdir()
    with pytest.raises(ExportError, match="it exists"):
        export_drive(drive, tmp_path / "bag", silent)


@given(st.floats(0.1, 2.0), st.floats(-1.0, 1.0))
def test_speeds_are_those_of_the_arc_that_was_driven(speed, turning):
    time = np.arange(50) * 0.02
    left = np.full(49, 0.02 * (speed - 0.25 * turning))
    right = np.full(49, 0.02 * (speed + 0.25 * turning))
    seen = speeds(time, integrate(arc(left, right, 0.5), (0.0, 0.0, 3.0)))
    assert seen[0].tolist() == [0.0, 0.0]
    np.testing.assert_allclose(seen[1:, 1], turning, atol=1e-9)
    np.testing.assert_allclose(seen[1:, 0], speed, rtol=1e-4)
