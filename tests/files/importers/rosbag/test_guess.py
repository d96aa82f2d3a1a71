"""The guess names what names make plain, and leaves the rest open."""

import pytest

from omnimate.files.importers.rosbag.guess import ambiguities, guess_plan, plan_as_toml
from omnimate.files.importers.rosbag.plan import ChannelSource, PoseSource, read_plan
from omnimate.files.importers.rosbag.reader import Topic
from omnimate.vehicle.parameters import CHANNELS

JOINTS, INT32 = "sensor_msgs/JointState", "std_msgs/Int32"
POSE, ODOMETRY, TF = "geometry_msgs/PoseStamped", "nav_msgs/Odometry", "tf2_msgs/TFMessage"


@pytest.mark.parametrize(
    "parts",
    [
        ("wheel_left_joint", "wheel_right_joint", "arm_left"),
        ("leftWheel", "rightWheel"),
        ("l_wheel", "r_wheel", "lift"),
        ("left", "right"),
    ],
)
def test_left_and_right_wheels_are_found_by_the_names_of_joints(parts):
    plan = guess_plan([Topic("/joint_states", JOINTS, 10, parts)])
    assert plan.channels == {
        "a.left": ChannelSource("/joint_states", parts[0]),
        "a.right": ChannelSource("/joint_states", parts[1]),
    }


def test_ticks_are_found_by_the_names_of_topics():
    topics = [Topic("/robot/left_ticks", INT32, 10), Topic("/robot/right_ticks", INT32, 10)]
    assert guess_plan(topics).channels["a.left"] == ChannelSource("/robot/left_ticks")


def test_two_that_are_named_alike_are_left_open():
    parts = ("front_left_wheel", "rear_left_wheel", "right_wheel")
    assert set(guess_plan([Topic("/joint_states", JOINTS, 10, parts)]).channels) == {"a.right"}


def test_each_of_several_that_are_named_alike_is_offered_until_one_is_given():
    parts, wheels = ("front_left_wheel", "rear_left_wheel", "right_wheel"), ("a.left", "a.right")
    topics = [Topic("/joints", JOINTS, 10, parts), Topic("/one", POSE, 1), Topic("/two", POSE, 1)]
    guess = guess_plan(topics)
    first, second = ambiguities(topics, wheels, guess)
    assert "--channel a.left=/joints:front_left_wheel or --channel a.left=/joints:rear_left_wheel" in first
    assert second.endswith("--pose a=/one or --pose a=/two")
    guess.channels["a.left"], guess.poses["a"] = ChannelSource("/joints", parts[1]), PoseSource("/one")
    assert ambiguities(topics, wheels, guess) == []


def test_channels_of_two_trucks_are_found_by_their_own_names():
    parts = tuple(channel.replace(".", "_") for channel in CHANNELS)
    plan = guess_plan([Topic("/joints", JOINTS, 10, parts)], CHANNELS)
    assert plan.channels == {
        channel: ChannelSource("/joints", part) for channel, part in zip(CHANNELS, parts, strict=True)
    }


@pytest.mark.parametrize(
    ("topics", "found"),
    [
        ([Topic("/pose", POSE, 1), Topic("/odom", ODOMETRY, 1)], "/pose"),
        ([Topic("/vicon/robot", POSE, 1), Topic("/amcl", POSE, 1)], "/vicon/robot"),
        ([Topic("/ground_truth/odom", ODOMETRY, 1), Topic("/odom", ODOMETRY, 1)], "/ground_truth/odom"),
        ([Topic("/odom", ODOMETRY, 1)], None),
        ([Topic("/one", POSE, 1), Topic("/two", POSE, 1)], None),
        ([Topic("/tf", TF, 1, ("base",))], None),
        ([Topic("/pose", POSE, 0)], None),
    ],
)
def test_poses_are_those_of_a_measurement_and_never_the_robots_own_odometry(topics, found):
    assert guess_plan(topics).poses == ({} if found is None else {"a": PoseSource(found)})


@pytest.mark.parametrize(("channels", "trucks"), [(CHANNELS, "ab"), (CHANNELS[:2], "a")])
def test_the_poses_of_all_trucks_are_found_on_the_topics_that_export_writes(channels, trucks):
    topics = [Topic("/poses/a", POSE, 9), Topic("/poses/b", POSE, 9), Topic("/odometry/a", ODOMETRY, 9)]
    assert guess_plan(topics, channels).poses == {truck: PoseSource(f"/poses/{truck}") for truck in trucks}


def test_a_guess_written_as_a_mapping_reads_back_the_same(tmp_path, robot):
    topics = [Topic("/joint_states", JOINTS, 10, ("left", "right")), Topic("/mocap", POSE, 10)]
    plan = guess_plan(topics)
    (tmp_path / "map.toml").write_text(plan_as_toml(plan))
    assert read_plan(tmp_path / "map.toml", robot)[0] == plan
