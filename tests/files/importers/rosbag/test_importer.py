"""Bags of every form become recordings; what is not in them, or cannot be, is a sentence."""

import math
from dataclasses import replace

import numpy as np
import pytest

from omnimate.files.errors import MappingError, SourceError
from omnimate.files.importers.rosbag.importer import read_bag
from omnimate.files.importers.rosbag.plan import plan_of_options, read_plan
from omnimate.files.importers.rosbag.reader import messages_of, topics_of
from omnimate.vehicle.file import save_vehicle

JOINTS, INT32, INT64 = "sensor_msgs/msg/JointState", "std_msgs/msg/Int32", "std_msgs/msg/Int64"
POSE, TF = "geometry_msgs/msg/PoseStamped", "tf2_msgs/msg/TFMessage"
WHEELS = ["a.left=/joints:left", "a.right=/joints:right"]
TICKS = ["a.left=/left", "a.right=/right"]
LATE = 0.004  # [s] by which the bag gets a message


def joints_of(maker, drive, stamped=True):
    for number, time in enumerate(drive.time.tolist()):
        angles = [drive.wheel_angle(wheel)[number] for wheel in ("a.right", "a.left")]
        content = maker.joints(time if stamped else 0.0, ["right", "left"], angles)
        yield "/joints", JOINTS, time + LATE, content


def ticks_of(maker, drive, bits=32):
    for time, (left, right) in zip(drive.time.tolist(), drive.counts.tolist(), strict=True):
        yield "/left", f"std_msgs/msg/Int{bits}", time, maker.ticks(left, bits)
        yield "/right", f"std_msgs/msg/Int{bits}", time, maker.ticks(right, bits)


def poses_of(drive, topic, kind, make):
    for time, pose in zip(drive.poses.time.tolist(), drive.poses.pose.tolist(), strict=True):
        yield topic, kind, time + LATE, make(time, *pose)


def in_order(*streams):
    return sorted((one for stream in streams for one in stream), key=lambda one: one[2])


def read(path, vehicle, channels=WHEELS, poses=()):
    return read_bag(path, plan_of_options(channels, poses), vehicle)


def test_a_recording_as_a_bag_of_any_form_comes_back_with_its_counts_times_and_poses(any_maker, drive, bag):
    poses = poses_of(drive, "/mocap", POSE, any_maker.stamped)
    path = bag(any_maker, in_order(joints_of(any_maker, drive), poses))
    back, notes = read(path, drive.vehicle, poses=["a=/mocap"])
    assert notes == ()
    np.testing.assert_array_equal(back.counts, drive.counts)
    np.testing.assert_allclose(back.time, drive.time, atol=1e-6)
    np.testing.assert_allclose(back.poses.time, drive.poses.time, atol=1e-6)
    np.testing.assert_allclose(back.poses.pose, drive.poses.pose, atol=1e-9)
    assert np.isnan(back.poses.sigma).all()


@pytest.mark.parametrize("bits", [32, 64])
def test_ticks_without_stamps_come_at_the_times_of_the_bag_and_a_note_says_so(maker, drive, bag, bits):
    back, notes = read(bag(maker, ticks_of(maker, drive, bits)), drive.vehicle, TICKS)
    np.testing.assert_array_equal(back.counts, drive.counts)
    np.testing.assert_allclose(back.time, drive.time, atol=1e-6)
    assert [note.split()[0] for note in notes] == ["/left", "/right"]
    assert all("no stamps" in note for note in notes)


@pytest.mark.parametrize(("stamped", "clock", "notes"), [(False, "header", 1), (True, "bag", 0)])
def test_zero_stamps_are_none_and_the_bags_own_times_can_be_asked_for(
    maker, drive, bag, stamped, clock, notes
):
    plan = replace(plan_of_options(WHEELS, []), stamps=clock)
    progress = []
    path = bag(maker, joints_of(maker, drive, stamped))
    back = read_bag(path, plan, drive.vehicle, lambda *one: progress.append(one))
    np.testing.assert_allclose(back.recording.time, drive.time + LATE, atol=1e-6)
    assert len(back.notes) == notes
    assert progress[0] == (0, len(drive))


def test_every_type_of_pose_gives_the_same_poses(maker, drive, bag):
    kinds = {
        "/stamped": (POSE, maker.stamped),
        "/covered": ("geometry_msgs/msg/PoseWithCovarianceStamped", maker.with_covariance),
        "/odom": ("nav_msgs/msg/Odometry", maker.odometry),
        "/transform": ("geometry_msgs/msg/TransformStamped", maker.transform),
    }
    streams = [poses_of(drive, topic, *kind) for topic, kind in kinds.items()]
    path = bag(maker, in_order(joints_of(maker, drive), *streams))
    for topic in kinds:
        back, notes = read(path, drive.vehicle, poses=[f"a={topic}"])
        np.testing.assert_allclose(back.poses.pose, drive.poses.pose, atol=1e-9)
        stated = topic in {"/covered", "/odom"}
        expected = [0.01, 0.02, math.nan] if stated else [math.nan] * 3
        np.testing.assert_allclose(back.poses.sigma[0], expected)
        assert any("no absolute pose" in note for note in notes) == (topic == "/odom")


def test_of_a_tf_topic_only_the_named_frame_is_taken(maker, drive, bag):
    def make(time, x, y, yaw):
        other = maker.transform(time, 9.0, 9.0, 0.0, "laser")
        return maker.transforms(other, maker.transform(time, x, y, yaw, "base"))

    path = bag(maker, in_order(joints_of(maker, drive), poses_of(drive, "/tf", TF, make)))
    back, _ = read(path, drive.vehicle, poses=["a=/tf:base"])
    np.testing.assert_allclose(back.poses.pose, drive.poses.pose, atol=1e-9)
    with pytest.raises(SourceError, match="name the robot's: TOPIC:FRAME"):
        read(path, drive.vehicle, poses=["a=/tf"])
    with pytest.raises(SourceError, match="no transform of frame 'nose'"):
        read(path, drive.vehicle, poses=["a=/tf:nose"])


def test_wheels_of_two_joint_states_on_their_own_times_meet(maker, drive, bag):
    sent = []
    for number, time in enumerate(drive.time.tolist()):
        for wheel, later in (("left", 0.0), ("right", 0.007)):
            angle = drive.wheel_angle(f"a.{wheel}")[number]
            sent.append(("/joints", JOINTS, time + later, maker.joints(time + later, [wheel], [angle])))
    back, _ = read(bag(maker, sent), drive.vehicle)
    right = np.interp(back.time, drive.time + 0.007, drive.channel_counts("a.right"))
    assert np.abs(back.channel_counts("a.right") - right).max() <= 0.5 + 1e-3


def test_speeds_of_joints_are_summed(maker, robot, bag):
    sent = [
        ("/joints", JOINTS, 0.02 * n, maker.joints(1.0 + 0.02 * n, ["left", "right"], [], [math.pi, 0.0]))
        for n in range(51)
    ]
    path = bag(maker, sent)
    back, _ = read(path, robot, ["a.left=/joints:left:rad/s", "a.right=/joints:right:rad/s"])
    assert back.counts[-1].tolist() == [500, 0]
    with pytest.raises(SourceError, match='has no position; unit "rad/s" takes its velocity'):
        read(path, robot)


def test_a_message_sent_twice_counts_once(maker, drive, bag):
    sent = list(joints_of(maker, drive))
    back, notes = read(bag(maker, [*sent[:5], sent[4], *sent[5:]]), drive.vehicle)
    np.testing.assert_array_equal(back.counts, drive.counts)
    assert any("1 message(s) with the stamp" in note for note in notes)


@pytest.mark.parametrize("form", ["ros1", "mcap-file", "db3-file"])
def test_bags_of_one_drive_in_a_folder_are_one_drive(makers, drive, bag, tmp_path, form):
    sent = list(joints_of(makers[form], drive))
    (tmp_path / "all").mkdir()
    for number, part in enumerate((sent[:100], sent[100:])):
        path = bag(makers[form], part, f"drive_{number}")
        path.rename(tmp_path / "all" / path.name)
    np.testing.assert_array_equal(read(tmp_path / "all", drive.vehicle)[0].counts, drive.counts)


def test_topics_are_listed_with_type_count_and_the_names_in_them(any_maker, drive, bag):
    streams = (joints_of(any_maker, drive), poses_of(drive, "/mocap", POSE, any_maker.stamped))
    topics = {topic.name: topic for topic in topics_of(bag(any_maker, in_order(*streams)))}
    assert topics["/joints"].parts == ("right", "left")
    assert (topics["/joints"].kind, topics["/joints"].count) == ("sensor_msgs/JointState", 200)
    assert topics["/mocap"].kind == "geometry_msgs/PoseStamped"


@pytest.mark.parametrize(
    ("channels", "poses", "problem"),
    [
        (["a.left=/joints:left"], [], r"nothing says which topic channel a\.right is"),
        (["a.left=/none:left", WHEELS[1]], [], "no topic /none; the bag has /joints, /mocap"),
        (["a.left=/joints:links", WHEELS[1]], [], "no message of that joint"),
        (["a.left=/mocap", WHEELS[1]], [], "messages geometry_msgs/PoseStamped have no field data"),
        (["a.left=/mocap:pose", WHEELS[1]], [], "pose of geometry_msgs/PoseStamped is no number"),
        (["a.left=/joints:left:counts", WHEELS[1]], [], "expected whole numbers"),
        (WHEELS, ["a=/joints"], "hold no pose; expected one of"),
        (WHEELS, ["b=/mocap"], "has no such truck"),
    ],
)
def test_what_the_bag_does_not_hold_is_said(maker, drive, bag, channels, poses, problem):
    path = bag(maker, in_order(joints_of(maker, drive), poses_of(drive, "/mocap", POSE, maker.stamped)))
    with pytest.raises(SourceError, match=problem):
        read(path, drive.vehicle, channels, poses)


def test_times_that_go_backwards_are_refused_with_the_message(maker, drive, bag):
    sent = list(joints_of(maker, drive))
    sent[7], sent[8] = (*sent[7][:3], sent[8][3]), (*sent[8][:3], sent[7][3])
    with pytest.raises(SourceError, match="message 9: time goes backwards"):
        read(bag(maker, sent), drive.vehicle)


@pytest.mark.parametrize(
    ("topic", "kind", "make", "problem"),
    [
        (
            "/joints",
            JOINTS,
            lambda m, t: m.joints(t, ["left", "right"], [0.0, math.nan]),
            "right is nan at 17",
        ),
        ("/mocap", POSE, lambda m, t: m.stamped(t, 0.0, math.nan, 0.0), "a pose that is no number"),
        ("/mocap", POSE, lambda m, t: m.stamped(t, 0.0, 0.0, None), "orientation of length 0"),
        ("/mocap", POSE, lambda m, t: m.stamped(t - 1.6e9, 0.0, 0.0, 0.0), "the poses lie at 100000000"),
    ],
)
def test_numbers_that_are_none_and_poses_on_another_clock_are_refused(
    maker, drive, bag, topic, kind, make, problem
):
    wrong = (topic, kind, drive.time[0], make(maker, drive.time[0]))
    poses = ["a=/mocap"] if topic == "/mocap" else []
    with pytest.raises(SourceError, match=problem):
        read(bag(maker, [wrong, *joints_of(maker, drive)]), drive.vehicle, poses=poses)


def test_an_empty_bag_is_refused(any_maker, robot, bag):
    path = bag(any_maker, [])
    with pytest.raises(SourceError, match=r"empty|cannot be read|damaged"):
        read(path, robot)


@pytest.mark.parametrize("suffix", [".bag", ".mcap", ".db3", ".txt"])
@pytest.mark.parametrize("content", [b"", b"junk" * 500])
def test_a_file_that_is_no_bag_is_refused(tmp_path, suffix, content):
    path = tmp_path / f"drive{suffix}"
    path.write_bytes(content)
    with pytest.raises(SourceError, match=r"drive\."):
        topics_of(path)


@pytest.mark.parametrize("size", [1 << 62, (1 << 64) - 1])
def test_a_damaged_size_that_no_memory_holds_is_a_sentence(tmp_path, size):
    path = tmp_path / "damaged.mcap"
    path.write_bytes(b"\x89MCAP0\r\n\x01" + size.to_bytes(8, "little") + bytes(100))
    with pytest.raises(SourceError, match="the bag is damaged"):
        topics_of(path)


def test_a_bag_cut_off_anywhere_is_a_sentence_or_the_messages_that_are_left(any_maker, drive, bag, tmp_path):
    path = bag(any_maker, joints_of(any_maker, drive))
    whole = path if path.is_file() else next(one for one in path.iterdir() if one.suffix != ".yaml")
    content = whole.read_bytes()
    cut = tmp_path / f"cut{whole.suffix}"
    for part in range(1, 16):
        cut.write_bytes(content[: part * len(content) // 16])
        try:
            left = len(list(messages_of(cut, ["/joints"])))
        except SourceError as error:
            left = 0 if str(cut) in str(error) else -1
        assert 0 <= left <= len(drive)


def test_no_such_bag_and_a_folder_without_one_are_refused(tmp_path):
    with pytest.raises(SourceError, match="no such file or folder"):
        topics_of(tmp_path / "none.bag")
    with pytest.raises(SourceError, match="no bag in it"):
        topics_of(tmp_path)


def test_a_mapping_file_says_topics_units_offsets_and_the_robot(maker, drive, bag, tmp_path):
    save_vehicle(drive.vehicle, tmp_path / "vehicle.toml")
    (tmp_path / "map.toml").write_text(
        'vehicle = "vehicle.toml"\nstamps = "header"\n'
        '[channel."a.left"]\ntopic = "/joints"\njoint = "left"\nunit = "rad"\n'
        '[channel."a.right"]\ntopic = "/right"\nfield = "data"\n'
        '[poses.a]\ntopic = "/mocap"\noffset = 0.25\n'
    )
    poses = poses_of(drive, "/mocap", POSE, maker.stamped)
    path = bag(maker, in_order(joints_of(maker, drive), ticks_of(maker, drive), poses))
    plan, robot = read_plan(tmp_path / "map.toml")
    back, _ = read_bag(path, plan, robot)
    assert robot == drive.vehicle
    np.testing.assert_allclose(back.poses.time, drive.poses.time + 0.25, atol=1e-6)
    np.testing.assert_allclose(back.channel_counts("a.right"), drive.channel_counts("a.right"), atol=1)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ('[channel."a.up"]\ntopic = "/x"', r"'a\.up' is unknown"),
        ('[channel."a.left"]\njoint = "left"', "topic is missing"),
        ('[channel."a.left"]\ntopic = "/x"\nunit = "miles"', "unit = 'miles'; expected one of"),
        ('[poses.a]\ntopic = "/x"\nchild = "y"', "unknown key 'child'"),
        ('stamps = "mine"', "stamps = 'mine'; expected one of header, bag"),
        ('stamp = "bag"', "unknown key 'stamp'"),
    ],
)
def test_a_bad_mapping_is_refused_with_its_key(tmp_path, robot, text, problem):
    (tmp_path / "map.toml").write_text(text)
    with pytest.raises(MappingError, match=problem):
        read_plan(tmp_path / "map.toml", robot)


@pytest.mark.parametrize(
    ("channels", "poses", "problem"),
    [
        (["a.left"], [], "expected CHANNEL=TOPIC"),
        (["a.left="], [], "expected CHANNEL=TOPIC"),
        (["a.left=/x:y:rad:z"], [], "expected CHANNEL=TOPIC"),
        (["left=/x"], [], "no channel; expected one of"),
        (["a.left=/x:y:miles"], [], "unit 'miles'"),
        ([], ["c=/x"], "no truck; expected one of a, b"),
    ],
)
def test_a_bad_option_is_refused(channels, poses, problem):
    with pytest.raises(MappingError, match=problem):
        plan_of_options(channels, poses)
