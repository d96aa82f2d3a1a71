"""The robot's own odometry while a drive is simulated: its pose and linkage from its counts."""

from typing import TYPE_CHECKING, Annotated

from omnimate.vehicle.arcs import roll
from omnimate.vehicle.compiled import Array, IntArray, Record, compiled, record
from omnimate.vehicle.parameters import CHANNELS

if TYPE_CHECKING:
    from omnimate.vehicle.parameters import VehicleParameters


class Odometry:
    """The robot's own odometry."""

    started: int  # 1 after the first sample
    counts: Annotated[IntArray, 2]  # unwrapped counts of truck a's wheels at the last sample
    scale: Annotated[Array, 2]  # travel per count of truck a's wheels [m]
    wheelbase: float  # nominal wheelbase of truck a [m]
    pose: Annotated[Array, 3]  # pose of truck a by dead reckoning [m, m, rad]
    # angle per count of joint_a and joint_b [rad], and length per count of the link [m]
    joint_scale: Annotated[Array, 3]
    # counts of the joints at angle 0, and of the link at its length at rest
    joint_zero: Annotated[IntArray, 3]
    link_length: float  # nominal length of the link at rest [m]


def odometry_of(vehicle: "VehicleParameters") -> Record:
    """Return the odometry record `(1,)` of a vehicle, at the origin."""
    odometry = record(Odometry)
    robot = odometry[0]
    robot["scale"] = [vehicle.metres_per_count("a.left"), vehicle.metres_per_count("a.right")]
    robot["wheelbase"] = vehicle.trucks["a"].wheelbase
    if vehicle.linkage is not None:
        robot["link_length"] = vehicle.linkage.length
        for number, channel in enumerate(CHANNELS[4:]):
            robot["joint_scale"][number] = vehicle.encoder(channel).scale
            robot["joint_zero"][number] = vehicle.encoder(channel).zero
    return odometry


@compiled
def update_odometry(
    odometry: Odometry, counts: IntArray
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Update odometry with the counts `(7,)` of one sample.

    Return the pose of truck a [m, m, rad], and the readings of the joints [rad] and the link [m].
    """
    if odometry.started:
        left = (counts[0] - odometry.counts[0]) * odometry.scale[0]
        right = (counts[1] - odometry.counts[1]) * odometry.scale[1]
        roll(odometry.pose, left, right, odometry.wheelbase)
    odometry.started = 1
    odometry.counts[0], odometry.counts[1] = counts[0], counts[1]
    joint_a = (counts[4] - odometry.joint_zero[0]) * odometry.joint_scale[0]
    joint_b = (counts[5] - odometry.joint_zero[1]) * odometry.joint_scale[1]
    link = odometry.link_length + (counts[6] - odometry.joint_zero[2]) * odometry.joint_scale[2]
    pose = odometry.pose
    return (pose[0], pose[1], pose[2]), (joint_a, joint_b, link)
