"""From the counts of one sample to travel, joint angles and link length, for correctors and filter.

Columns stand in the order of `CHANNELS`, wheels in that of `WHEELS`; truck a is 0, truck b 1.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import numpy as np

from omnimate.ipec.errors import NoLinkageError
from omnimate.vehicle.compiled import Array, IntArray, Record, compiled, record
from omnimate.vehicle.parameters import CHANNELS, WHEELS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from omnimate.vehicle.parameters import Channel, VehicleParameters
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.sample import Sample


class Scales:
    """Scale factors and geometry of a robot."""

    scale: Annotated[Array, 7]  # metres per count of a wheel and of the link, radians per count of a joint
    zero: Annotated[IntArray, 7]  # counts at angle 0, or at the link's length at rest
    length: float  # length of the link at rest [m]
    wheelbase: Annotated[Array, 2]  # wheelbase of truck a and b [m]


class Reading:
    """One sample in SI units, and the counts that the next one starts from."""

    started: Annotated[IntArray, 2]  # 1 for a truck whose wheels have been read
    counts: Annotated[IntArray, 4]  # counts of each wheel where its truck was last read
    moved: Annotated[IntArray, 2]  # 1 for a truck whose wheels were both read now and in an earlier sample
    travel: Annotated[Array, 4]  # travel of each wheel since its truck was last read [m]
    linked: int  # 1 where both joints and the link were read
    joint: Annotated[Array, 2]  # angles of joint_a and joint_b [rad]
    length: float  # length of the link [m]


def scales_of(vehicle: VehicleParameters, fields: type[Scales] = Scales) -> Record:
    """Return the scales of a robot with two trucks as one record `(1,)`; `fields` may be a class with more.

    Raises:
        NoLinkageError: The robot has a single truck.
    """
    if vehicle.linkage is None:
        raise NoLinkageError(vehicle.name)
    records = record(fields)
    scales = records[0]
    scales["scale"] = [vehicle.encoder(channel).scale for channel in CHANNELS]
    scales["scale"][:4] = [vehicle.metres_per_count(wheel) for wheel in WHEELS]
    scales["zero"] = [vehicle.encoder(channel).zero for channel in CHANNELS]
    scales["length"] = vehicle.linkage.length
    scales["wheelbase"] = [vehicle.trucks["a"].wheelbase, vehicle.trucks["b"].wheelbase]
    return records


@compiled
def convert_counts(scales: Scales, reading: Reading, counts: IntArray, present: NDArray[np.bool_]) -> None:
    """Convert one sample's counts to SI units; a truck moves only if both of its wheels are present.

    `reading` is that of the sample before; changed to that of this sample. Counts and presence `(7,)` are in
    the order of `CHANNELS`.
    """
    for truck in range(2):
        left, right = 2 * truck, 2 * truck + 1
        both = present[left] and present[right]
        reading.moved[truck] = 1 if both and reading.started[truck] else 0
        for wheel in (left, right):
            step = counts[wheel] - reading.counts[wheel]
            reading.travel[wheel] = step * scales.scale[wheel] if reading.moved[truck] else 0.0
            if both:
                reading.counts[wheel] = counts[wheel]
        if both:
            reading.started[truck] = 1
    reading.linked = 1 if present[4] and present[5] and present[6] else 0
    for joint in range(2):
        reading.joint[joint] = (counts[4 + joint] - scales.zero[4 + joint]) * scales.scale[4 + joint]
    reading.length = scales.length + (counts[6] - scales.zero[6]) * scales.scale[6]


def ordered_counts(recording: Recording) -> tuple[IntArray, NDArray[np.bool_]]:
    """Return counts and presence `(N, 7)` of a recording with the columns of `CHANNELS`.

    Raises:
        NoLinkageError: The robot has a single truck.
    """
    if recording.vehicle.linkage is None:
        raise NoLinkageError(recording.source)
    columns = columns_of(recording.vehicle, CHANNELS)
    counts = np.ascontiguousarray(recording.counts[:, columns])
    return counts, np.ascontiguousarray(recording.present[:, columns])


def columns_of(vehicle: VehicleParameters, channels: Sequence[Channel]) -> list[int]:
    """Return the columns of channels in samples and recordings of a robot that has them."""
    return [vehicle.channels.index(channel) for channel in channels]


def read_sample(sample: Sample, columns: Sequence[int]) -> tuple[IntArray, NDArray[np.bool_]]:
    """Return the counts `(C,)` in some columns of a live sample, and whether each was read `(C,)`."""
    counts, present = [sample.counts[at] for at in columns], [sample.present[at] for at in columns]
    return np.array(counts, np.int64), np.array(present, np.bool_)
