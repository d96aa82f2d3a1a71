"""What the robot works out from its own counts while a drive is simulated: its pose, and the linkage."""

from typing import TYPE_CHECKING, Annotated

from vcan_sim.signal_path import advance_arc
from vehicle.compiled import Array, IntArray, Record, compiled, record
from vehicle.parameters import CHANNELS

if TYPE_CHECKING:
    from vehicle.parameters import VehicleParameters


class Odometry:
    """What the robot works out from its own counts.

    Attributes:
        started: 1 after the first sample.
        counts: of truck a's wheels at the last sample.
        scale: metres per count of these wheels [m].
        wheelbase: nominal [m].
        pose: of truck a.
        joint_scale: radians per count, metres per count for the link.
        joint_zero: counts at angle 0, or at the link's length at rest.
        link_length: at rest, nominal [m].
    """

    started: int
    counts: Annotated[IntArray, 2]
    scale: Annotated[Array, 2]
    wheelbase: float
    pose: Annotated[Array, 3]
    joint_scale: Annotated[Array, 3]
    joint_zero: Annotated[IntArray, 3]
    link_length: float


def odometry_of(vehicle: "VehicleParameters") -> Record:
    """Return the odometry record `(1,)` of a vehicle, at the origin."""
    odometry = record(Odometry)
    own = odometry[0]
    own["scale"] = [vehicle.metres_per_count("a.left"), vehicle.metres_per_count("a.right")]
    own["wheelbase"] = vehicle.trucks["a"].wheelbase
    if vehicle.linkage is not None:
        own["link_length"] = vehicle.linkage.length
        for number, channel in enumerate(CHANNELS[4:]):
            own["joint_scale"][number] = vehicle.encoder(channel).scale
            own["joint_zero"][number] = vehicle.encoder(channel).zero
    return odometry


@compiled
def see(
    odometry: Odometry, counts: IntArray
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Return the pose of truck a by dead reckoning, and what the linkage reads, from one sample's counts."""
    pose = odometry.pose[0], odometry.pose[1], odometry.pose[2]
    if odometry.started:
        left = (counts[0] - odometry.counts[0]) * odometry.scale[0]
        right = (counts[1] - odometry.counts[1]) * odometry.scale[1]
        pose = advance_arc(pose, left, right, odometry.wheelbase)
    odometry.started = 1
    odometry.counts[0], odometry.counts[1] = counts[0], counts[1]
    odometry.pose[0], odometry.pose[1], odometry.pose[2] = pose
    joint_a = (counts[4] - odometry.joint_zero[0]) * odometry.joint_scale[0]
    joint_b = (counts[5] - odometry.joint_zero[1]) * odometry.joint_scale[1]
    link = odometry.link_length + (counts[6] - odometry.joint_zero[2]) * odometry.joint_scale[2]
    return pose, (joint_a, joint_b, link)
