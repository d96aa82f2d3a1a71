"""Robots, recordings and bags that the importers are tried on."""

import numpy as np
import pytest
from rosbags import rosbag1, rosbag2
from rosbags.typesys import Stores, get_typestore

from omnimate.files.importers.clock import recording_of
from omnimate.files.importers.robots import single_truck
from omnimate.files.importers.series import Series, poses_of
from omnimate.vehicle.parameters import Truck


@pytest.fixture
def robot():
    """A differential drive with slightly unequal wheels, 1000 counts per turn."""
    return single_truck("tried", Truck(0.5, 0.2, 0.201), 1000.0, 0.02)


@pytest.fixture
def drive(robot):
    """Four seconds of a bend at 50 Hz, with poses at every fifth sample, on an epoch clock."""
    time = 1_700_000_000.0 + 0.02 * np.arange(200)
    steps = np.arange(200)
    left, right = (Series(time, speed * steps, "counts", "test") for speed in (3.0, 4.0))
    pose = np.column_stack((0.002 * steps, 0.001 * steps, 0.05 * steps))[::5]
    return recording_of(robot, {"a.left": left, "a.right": right}, "test", poses_of("a", time[::5], pose))


COLUMNS = """
[time]
column = "t"
[channel."a.left"]
column = "left"
[channel."a.right"]
column = "right"
"""
POSES = """
[poses.a]
x = "x"
y = "y"
theta = "yaw"
"""
FORMS = ("ros1", "sqlite3", "mcap", "mcap-file", "db3-file")


class Maker:
    """Messages of one ROS."""

    def __init__(self, form):
        self.form = form
        self.store = get_typestore(Stores.ROS1_NOETIC if form == "ros1" else Stores.ROS2_HUMBLE)

    def make(self, kind, **fields):
        return self.store.types[kind](**fields)

    def header(self, time, frame="world"):
        sec, nanosec = divmod(round(time * 1e9), 1_000_000_000)
        stamp = self.make("builtin_interfaces/msg/Time", sec=sec, nanosec=nanosec)
        more = {"seq": 0} if self.form == "ros1" else {}
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id=frame, **more)

    def joints(self, time, names, position, velocity=()):
        return self.make(
            "sensor_msgs/msg/JointState",
            header=self.header(time),
            name=list(names),
            position=np.array(position, float),
            velocity=np.array(velocity, float),
            effort=np.array([]),
        )

    def ticks(self, value, bits=32):
        return self.make(f"std_msgs/msg/Int{bits}", data=value)

    def turn(self, yaw):
        """Return a heading as a quaternion; None gives one that nobody filled in."""
        z, w = (0.0, 0.0) if yaw is None else (float(np.sin(yaw / 2)), float(np.cos(yaw / 2)))
        return self.make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=z, w=w)

    def pose(self, x, y, yaw):
        point = self.make("geometry_msgs/msg/Point", x=float(x), y=float(y), z=0.3)
        return self.make("geometry_msgs/msg/Pose", position=point, orientation=self.turn(yaw))

    def stamped(self, time, x, y, yaw):
        return self.make("geometry_msgs/msg/PoseStamped", header=self.header(time), pose=self.pose(x, y, yaw))

    def covered(self, x, y, yaw):
        variances = np.zeros(36)
        variances[[0, 7]] = 0.01**2, 0.02**2
        return self.make(
            "geometry_msgs/msg/PoseWithCovariance", pose=self.pose(x, y, yaw), covariance=variances
        )

    def with_covariance(self, time, x, y, yaw):
        return self.make(
            "geometry_msgs/msg/PoseWithCovarianceStamped",
            header=self.header(time),
            pose=self.covered(x, y, yaw),
        )

    def odometry(self, time, x, y, yaw):
        zero = self.make("geometry_msgs/msg/Vector3", x=0.0, y=0.0, z=0.0)
        twist = self.make(
            "geometry_msgs/msg/TwistWithCovariance",
            twist=self.make("geometry_msgs/msg/Twist", linear=zero, angular=zero),
            covariance=np.zeros(36),
        )
        return self.make(
            "nav_msgs/msg/Odometry",
            header=self.header(time),
            child_frame_id="base",
            pose=self.covered(x, y, yaw),
            twist=twist,
        )

    def transform(self, time, x, y, yaw, frame="base"):
        place = self.make("geometry_msgs/msg/Vector3", x=float(x), y=float(y), z=0.0)
        return self.make(
            "geometry_msgs/msg/TransformStamped",
            header=self.header(time),
            child_frame_id=frame,
            transform=self.make("geometry_msgs/msg/Transform", translation=place, rotation=self.turn(yaw)),
        )

    def transforms(self, *several):
        return self.make("tf2_msgs/msg/TFMessage", transforms=list(several))


def write_bag(path, maker, sent):
    """Write messages as a bag of the maker's form; return what a user would name."""
    if maker.form == "ros1":
        path = path.with_suffix(".bag")
        opened, serialise = rosbag1.Writer(path), maker.store.serialize_ros1
    else:
        plugin = rosbag2.StoragePlugin.MCAP if "mcap" in maker.form else rosbag2.StoragePlugin.SQLITE3
        opened, serialise = rosbag2.Writer(path, version=9, storage_plugin=plugin), maker.store.serialize_cdr
    with opened as writer:
        connections = {}
        for topic, kind, time, content in sent:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=maker.store)
            writer.write(connections[topic], round(time * 1e9), bytes(serialise(content, kind)))
    return next(path.glob(f"*.{maker.form[:-5]}")) if maker.form.endswith("-file") else path


@pytest.fixture
def maker():
    """What makes the messages of a ROS 2 bag in MCAP."""
    return Maker("mcap")


@pytest.fixture(params=FORMS)
def any_maker(request):
    """What makes the messages of a bag of each form."""
    return Maker(request.param)


@pytest.fixture
def bag(tmp_path):
    """Return a function that writes messages (topic, type, time of the bag [s], content) as a bag."""
    return lambda maker, sent, name="drive": write_bag(tmp_path / name, maker, sent)


@pytest.fixture
def makers():
    """What makes the messages of a bag, by its form."""
    return {form: Maker(form) for form in FORMS}
