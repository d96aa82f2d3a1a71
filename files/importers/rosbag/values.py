"""Values in ROS messages: of a wheel or a joint, or a pose with its covariance, and the stamp."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

from omnimate.files.errors import SourceError

if TYPE_CHECKING:
    from omnimate.files.importers.rosbag.plan import ChannelSource, PoseSource
    from omnimate.files.importers.rosbag.reader import Message

JOINTS = "sensor_msgs/JointState"
POSES = (
    "geometry_msgs/PoseStamped",
    "geometry_msgs/PoseWithCovarianceStamped",
    "geometry_msgs/TransformStamped",
    "nav_msgs/Odometry",
    "tf2_msgs/TFMessage",
    "tf/tfMessage",
)
_SPEED = "rad/s"
_VARIANCES = (0, 7, 35)  # x, y and yaw on the diagonal of ROS's 6 x 6
_NORM_TOLERANCE = 0.1  # largest difference of a quaternion's length from 1


class StampedValue(NamedTuple):
    """The value of a channel or of a pose, with its stamp.

    Attributes:
        stamp: Stamp of the header [ns]; 0 where there is none.
        numbers: The value of a channel, or x, y [m], theta [rad] of a pose and their standard deviations.
    """

    stamp: int
    numbers: tuple[float, ...]


def channel_value(message: Message, source: ChannelSource) -> StampedValue | None:
    """Return the value of a channel in a message; None where a JointState is of other joints.

    Raises:
        SourceError: The message lacks the field, or the field holds no number.
    """
    if message.kind == JOINTS:
        names = list(message.content.name)
        if source.part not in names:
            return None
        field = "velocity" if source.unit == _SPEED else "position"
        values, place = getattr(message.content, field), names.index(source.part)
        if place >= len(values):
            raise SourceError(
                message.topic,
                f"joint {source.part} has no {field}"
                + ('; unit "rad/s" takes its velocity' if field == "position" else ""),
            )
        value = values[place]
    else:
        value = _field(message, source.part or "data")
    return StampedValue(_stamp(message.content), (_number(message, value, source.part or "data"),))


def pose_value(message: Message, source: PoseSource) -> StampedValue | None:
    """Return the pose in a message; None where its transforms are of other frames.

    Raises:
        SourceError: The type of the message has no pose, or the pose is not possible.
    """
    if message.kind not in POSES:
        raise SourceError(
            message.topic, f"messages {message.kind} hold no pose; expected one of {', '.join(POSES)}"
        )
    if message.kind.startswith("tf") and not source.frame:
        raise SourceError(message.topic, f"{message.kind} holds many frames; name the robot's: TOPIC:FRAME")
    content = _stamped(message.content, source.frame)
    if content is None:
        return None
    pose = content.transform if hasattr(content, "transform") else content.pose
    covariance = getattr(pose, "covariance", None)
    pose = getattr(pose, "pose", pose)
    place = pose.translation if hasattr(pose, "translation") else pose.position
    turn = pose.rotation if hasattr(pose, "rotation") else pose.orientation
    numbers = (place.x, place.y, turn.x, turn.y, turn.z, turn.w)
    if not all(math.isfinite(number) for number in numbers):
        raise SourceError(message.topic, f"a pose that is no number at {message.time / 1e9:.6f} s of the bag")
    return StampedValue(_stamp(content), (place.x, place.y, _yaw(message, turn), *_deviations(covariance)))


def _stamped(content: Any, frame: str) -> Any:  # noqa: ANN401 - messages are made at run time
    """Return the transform of a frame among several; any other message unchanged."""
    if not hasattr(content, "transforms"):
        return content
    wanted = frame.lstrip("/")
    return next((each for each in content.transforms if each.child_frame_id.lstrip("/") == wanted), None)


def _yaw(message: Message, turn: Any) -> float:  # noqa: ANN401 - likewise
    """Return the heading of a quaternion [rad], rotation about z of the order z, y, x."""
    length = math.sqrt(turn.x**2 + turn.y**2 + turn.z**2 + turn.w**2)
    if abs(length - 1.0) > _NORM_TOLERANCE:
        raise SourceError(
            message.topic,
            f"an orientation of length {length:g} at {message.time / 1e9:.6f} s of the bag; expected a "
            "quaternion of length 1",
        )
    return math.atan2(2.0 * (turn.w * turn.z + turn.x * turn.y), length**2 - 2.0 * (turn.y**2 + turn.z**2))


def _deviations(covariance: Any) -> tuple[float, ...]:  # noqa: ANN401 - likewise
    """Return the standard deviations of x, y and theta; nan where they are not stated (0 or below)."""
    if covariance is None:
        return (math.nan,) * 3
    variances = [float(covariance[place]) for place in _VARIANCES]
    return tuple(math.sqrt(variance) if variance > 0.0 else math.nan for variance in variances)


def _stamp(content: Any) -> int:  # noqa: ANN401 - likewise
    stamp = getattr(getattr(content, "header", None), "stamp", None)
    return 0 if stamp is None else int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def _field(message: Message, path: str) -> Any:  # noqa: ANN401 - likewise
    value = message.content
    for name in path.split("."):
        try:
            value = value[int(name)] if name.isdecimal() else getattr(value, name)
        except (AttributeError, IndexError, TypeError) as error:
            fields = ", ".join(field for field in vars(message.content) if not field.startswith("_"))
            raise SourceError(
                message.topic, f"messages {message.kind} have no field {path}; they have {fields}"
            ) from error
    return value


def _number(message: Message, value: Any, part: str) -> float:  # noqa: ANN401 - likewise
    try:
        number = float(value)
    except (TypeError, ValueError) as error:
        raise SourceError(message.topic, f"{part} of {message.kind} is no number") from error
    if not math.isfinite(number):
        raise SourceError(message.topic, f"{part} is {number} at {message.time / 1e9:.6f} s of the bag")
    return number
