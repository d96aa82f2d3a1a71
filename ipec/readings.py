"""From the counts of one sample to travel, joint angles and link length: what every corrector works on.

Columns stand in the order of `CHANNELS`, wheels in that of `WHEELS`; truck a is 0, truck b 1.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import numpy as np

from ipec.errors import NoLinkageError
from vehicle.compiled import Array, IntArray, Record, compiled, record
from vehicle.parameters import CHANNELS, WHEELS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from vehicle.parameters import VehicleParameters
    from vehicle.recording import Recording
    from vehicle.sample import Sample


class Scales:
    """What does not change from sample to sample.

    Attributes:
        scale: metres per count of a wheel and of the link, radians per count of a joint, `(7,)`.
        zero: counts at angle 0, or at the link's length at rest, `(7,)`.
        length: of the link at rest [m].
        wheelbase: of each truck [m].
    """

    scale: Annotated[Array, 7]
    zero: Annotated[IntArray, 7]
    length: float
    wheelbase: Annotated[Array, 2]


class Reading:
    """One sample in SI units, and the counts that the next one starts from.

    Attributes:
        started: 1 for each truck whose wheels have been read.
        counts: of each wheel where its truck was last read.
        moved: 1 for each truck whose wheels were both read in this sample and once before.
        travel: of each wheel since its truck was last read [m].
        linked: 1 where both joints and the link were read.
        joint: joint_a and joint_b [rad].
        length: of the link [m].
    """

    started: Annotated[IntArray, 2]
    counts: Annotated[IntArray, 4]
    moved: Annotated[IntArray, 2]
    travel: Annotated[Array, 4]
    linked: int
    joint: Annotated[Array, 2]
    length: float


def scales_of(vehicle: VehicleParameters) -> Record:
    """Return the scales `(1,)` of a robot with two trucks.

    Raises:
        NoLinkageError: it has one.
    """
    if vehicle.linkage is None:
        raise NoLinkageError(vehicle.name)
    scales = record(Scales)
    own = scales[0]
    own["scale"] = [vehicle.encoder(channel).scale for channel in CHANNELS]
    own["scale"][:4] = [vehicle.metres_per_count(wheel) for wheel in WHEELS]
    own["zero"] = [vehicle.encoder(channel).zero for channel in CHANNELS]
    own["length"] = vehicle.linkage.length
    own["wheelbase"] = [vehicle.trucks["a"].wheelbase, vehicle.trucks["b"].wheelbase]
    return scales


@compiled
def sense(scales: Scales, reading: Reading, counts: IntArray, present: NDArray[np.bool_]) -> None:
    """Take one sample's counts `(7,)`: a truck moves only where both of its wheels are present."""
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


def table_of(recording: Recording) -> tuple[IntArray, NDArray[np.bool_]]:
    """Return counts and presence `(N, 7)` of a recording with the columns of `CHANNELS`.

    Raises:
        NoLinkageError: the robot has a single truck.
    """
    if recording.vehicle.linkage is None:
        raise NoLinkageError(recording.source)
    columns = [recording.vehicle.channels.index(channel) for channel in CHANNELS]
    counts = np.ascontiguousarray(recording.counts[:, columns])
    return counts, np.ascontiguousarray(recording.present[:, columns])


class SampleReader:
    """Puts the counts of live samples into the order of `CHANNELS`."""

    def __init__(self, vehicle: VehicleParameters) -> None:
        """Raise NoLinkageError for a robot with a single truck."""
        if vehicle.linkage is None:
            raise NoLinkageError(vehicle.name)
        self._columns = [vehicle.channels.index(channel) for channel in CHANNELS]

    def read(self, sample: Sample) -> tuple[IntArray, NDArray[np.bool_]]:
        """Return the counts and presence of one sample, each `(7,)`."""
        counts = [sample.counts[column] for column in self._columns]
        present = [sample.present[column] for column in self._columns]
        return np.array(counts, np.int64), np.array(present, np.bool_)
