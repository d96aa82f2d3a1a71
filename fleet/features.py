"""The features of one recording, and their tables: segments, crossed cells, biases of the joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimate.fleet.segments import JOINT_NUMBERS, Crossings, Segments
from omnimate.ipec.filter.estimate import estimate
from omnimate.ipec.filter.prior import MONITORING_PRIOR

if TYPE_CHECKING:
    from collections.abc import Mapping

    from omnimate.vehicle.parameters import VehicleParameters
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array

MIN_SEGMENTS = 2  # segments of a recording that are needed to estimate its robot's parameters
_JOINT_SIGMAS = slice(8, 10)  # columns of `SlowParameters.sigma` for joint_a and joint_b


@dataclass(frozen=True, slots=True)
class Joints:
    """Biases of the joints' encoders.

    Of joint_a and joint_b [rad], `(2,)`; `(0,)` for a robot without a linkage.
    """

    bias: Array
    sigma: Array


NO_JOINTS = Joints(np.zeros(0), np.zeros(0))


@dataclass(frozen=True, slots=True)
class RecordingFeatures:
    """The features of one recording.

    The day is YYYY-MM-DD; there are `MIN_SEGMENTS` segments or more; the floor is "" for the only one.
    """

    robot: str
    kind: str
    day: str
    segments: Segments
    crossings: Crossings
    joints: Joints = NO_JOINTS
    floor: str = ""


def estimate_joints(recording: Recording) -> Joints:
    """Return the biases of the joints' encoders by the IPEC filter; `NO_JOINTS` without a linkage.

    Raises:
        LinkageChannelError: A channel of the linkage was never read, or was frozen.
    """
    if recording.vehicle.linkage is None:
        return NO_JOINTS
    slow = estimate(recording, prior=MONITORING_PRIOR).slow
    return Joints(np.array(slow.joint_bias), np.array(slow.sigma[_JOINT_SIGMAS]))


def name_kind(vehicle: VehicleParameters) -> str:
    """Return the type of a robot: wheelbase, mean wheel diameter, and length of a linkage, in words."""
    truck = vehicle.trucks["a"]
    mean = 0.5 * (truck.wheel_diameter_left + truck.wheel_diameter_right)
    linkage = "" if vehicle.linkage is None else f", link {vehicle.linkage.length:.1f} m"
    return f"wheelbase {truck.wheelbase:.2f} m, wheels {mean:.2f} m{linkage}"


def segment_columns(segments: Segments) -> dict[str, Any]:
    """Return the columns of the table `ways`."""
    count = len(segments)
    return {
        "way": np.arange(count, dtype=np.int32),
        "time": segments.time,
        "residual": segments.residual.tolist(),
        "jacobian": segments.jacobian.reshape(count, 9).tolist(),
        "rough": segments.unit_covariance.reshape(count, 9).tolist(),
        "lever": segments.lever.tolist(),
        "sigma": segments.sigma.reshape(count, 6).tolist(),
        "follows": segments.follows,
    }


def crossing_columns(crossings: Crossings) -> dict[str, Any]:
    """Return the columns of the table `crossings`."""
    return {
        "way": crossings.segment,
        "x": np.ascontiguousarray(crossings.cell[:, 0]),
        "y": np.ascontiguousarray(crossings.cell[:, 1]),
        "loss_x": crossings.loss[:, 0].astype(np.float32),
        "loss_y": crossings.loss[:, 1].astype(np.float32),
        "loss_theta": crossings.loss[:, 2].astype(np.float32),
        "creep": crossings.creep.astype(np.float32),
    }


def features_from_tables(
    row: Mapping[str, Any], ways: Mapping[str, Any], crossed: Mapping[str, Any], numbers: Mapping[str, Any]
) -> RecordingFeatures | None:
    """Return the features in a recording's tables; None if it has fewer than `MIN_SEGMENTS` segments.

    The row is that of `recordings`, with `robot` and `day` of its partition; the others are columns of its
    `ways`, `crossings` and `numbers`.
    """
    count = len(ways["way"])
    if count < MIN_SEGMENTS:
        return None
    segments = Segments(
        ways["time"],
        np.array(ways["residual"]),
        np.array(ways["jacobian"]).reshape(count, 3, 3),
        np.array(ways["rough"]).reshape(count, 3, 3),
        np.array(ways["lever"]),
        np.array(ways["sigma"]).reshape(count, 2, 3),
        np.asarray(ways["follows"], np.bool_),
    )
    crossings = Crossings(
        crossed["way"],
        np.column_stack([crossed["x"], crossed["y"]]),
        np.column_stack([crossed["loss_x"], crossed["loss_y"], crossed["loss_theta"]]),
        crossed["creep"],
    )
    rows = [numbers["name"].index(name) for name in JOINT_NUMBERS if name in numbers["name"]]
    joints = Joints(numbers["value"][rows], numbers["sigma"][rows]) if rows else NO_JOINTS
    return RecordingFeatures(row["robot"], row["kind"], row["day"], segments, crossings, joints, row["floor"])
