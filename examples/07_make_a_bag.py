"""Write a small ROS 2 bag: wheel positions as JointState, and the robot's pose from motion capture.

The drive is simulated, so that the example needs no robot. Usage: python 07_make_a_bag.py VEHICLE.toml BAG
"""

import math
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

import omnimate
from omnimate.motion import paths
from omnimate.vehicle.odometry import dead_reckon, truck_travel

STORE = get_typestore(Stores.ROS2_HUMBLE)
TYPES = SimpleNamespace(**{name.rpartition("/")[2]: kind for name, kind in STORE.types.items()})
JOINTS, POSES = "/joint_states", "/mocap/pose"


def header(time: float) -> object:
    """Return the header of a message of a time [s]."""
    sec, nanosec = divmod(round(time * 1e9), 1_000_000_000)
    return TYPES.Header(stamp=TYPES.Time(sec=sec, nanosec=nanosec), frame_id="world")


def joints(time: float, left: float, right: float) -> object:
    """Return a message of the wheels' angles [rad]."""
    names, empty = ["left_wheel", "right_wheel"], np.array([])
    return TYPES.JointState(
        header=header(time), name=names, position=np.array([left, right]), velocity=empty, effort=empty
    )


def pose(time: float, x: float, y: float, theta: float) -> object:
    """Return a message of a pose [m, m, rad]."""
    turn = TYPES.Quaternion(x=0.0, y=0.0, z=math.sin(0.5 * theta), w=math.cos(0.5 * theta))
    where = TYPES.Pose(position=TYPES.Point(x=x, y=y, z=0.0), orientation=turn)
    return TYPES.PoseStamped(header=header(time), pose=where)


def motion_capture(recording: omnimate.Recording) -> np.ndarray:
    """Return where the robot is seen, shape `(N, 3)`: its true wheelbase is 1.5 % less than described."""
    described = recording.vehicle.trucks["a"]
    truck = replace(described, wheelbase=0.985 * described.wheelbase)
    true = replace(recording, vehicle=replace(recording.vehicle, trucks={"a": truck}))
    noise = np.random.default_rng(1).normal(0.0, 0.002, (len(recording), 3))
    return dead_reckon(true, "a") + noise


def main(vehicle_file: Path, bag: Path) -> None:
    """Simulate two figures of eight and write what ROS would have recorded."""
    vehicle = omnimate.load_vehicle(vehicle_file)
    eight = paths.figure_eight(laps=2)
    recording = omnimate.simulate(vehicle, eight, seed=1, start_time=1_763_670_000.0)
    left, right, _ = truck_travel(recording, "a")
    angles = np.column_stack((left, right)) / (0.5 * vehicle.trucks["a"].wheel_diameter_left)
    measured = motion_capture(recording)
    with Writer(bag, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        topics = {JOINTS: "sensor_msgs/msg/JointState", POSES: "geometry_msgs/msg/PoseStamped"}
        links = {topic: writer.add_connection(topic, kind, typestore=STORE) for topic, kind in topics.items()}
        for row, time in enumerate(recording.time.tolist()):
            messages = {JOINTS: joints(time, *angles[row].tolist())}
            if row % 10 == 0:
                messages[POSES] = pose(time, *measured[row].tolist())
            for topic, message in messages.items():
                data = STORE.serialize_cdr(message, topics[topic])
                writer.write(links[topic], round(time * 1e9), data)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
