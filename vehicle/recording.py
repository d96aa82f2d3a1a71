"""The recording of a drive, measured or simulated: frozen named arrays on one clock.

A measured and a simulated drive are the same type, so that their difference is a subtraction.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from omnimate.vehicle.errors import RecordingError
from omnimate.vehicle.se2 import Array, wrap

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from omnimate.vehicle.parameters import Channel, TruckName, VehicleParameters

Direction = Literal["cw", "ccw", "none"]
GapReason = Literal["missing", "reboot", "jump"]

DIRECTIONS: tuple[Direction, ...] = get_args(Direction)


@dataclass(frozen=True, slots=True)
class Poses:
    """Absolute poses, measured from outside, in order of time.

    Attributes:
        time: Time of each pose on the recording's clock [s], shape `(M,)`.
        body: Truck that was measured, "a" or "b", shape `(M,)`.
        pose: Measured x [m], y [m], theta [rad], shape `(M, 3)`; nan where unknown.
        sigma: Standard deviations of x [m], y [m], theta [rad], shape `(M, 3)`; nan where unknown. One of 0,
            which no measurement has, is unknown.
    """

    time: Array
    body: NDArray[np.str_]
    pose: Array
    sigma: Array

    def __post_init__(self) -> None:
        count = len(self.time)
        shapes = (self.body.shape, self.pose.shape, self.sigma.shape)
        if shapes != ((count,), (count, 3), (count, 3)):
            raise ValueError(f"poses of shapes {shapes} do not belong to {count} times")
        object.__setattr__(self, "sigma", np.where(self.sigma == 0.0, np.nan, self.sigma))
        _freeze(self.time, self.body, self.pose, self.sigma)

    def of(self, truck: TruckName) -> Poses:
        """Return the poses of one truck."""
        return self.select(self.body == truck)

    def select(self, rows: NDArray[np.bool_ | np.int64] | np.bool_) -> Poses:
        """Return the poses where a mask `(M,)` is true, or those with these numbers."""
        return Poses(self.time[rows], self.body[rows], self.pose[rows], self.sigma[rows])


@dataclass(frozen=True, slots=True)
class Lap:
    """A section of a drive, such as one square, that may be held out."""

    direction: Direction  # direction of a closed path, cw or ccw; "none" for any other path
    start: float  # [s] on the recording's clock
    end: float  # [s] likewise


@dataclass(frozen=True, slots=True)
class Run:
    """The protocol of a drive and its laps."""

    protocol: str  # umbmark, extended-umbmark, straight, free, or another word
    side: float | None  # side of the square [m]; None where no square was driven
    laps: tuple[Lap, ...]  # the laps in order of time
    floor: str = ""  # name of the floor that it was driven on; "" where a robot has one floor only


@dataclass(frozen=True, slots=True)
class Gap:
    """An interval in which a channel was not read, or a time at which its counter was re-baselined."""

    channel: Channel
    start: float  # time of the last good sample before the gap [s]
    end: float  # time of the first good sample after the gap [s]
    reason: GapReason  # why: frames were missing, the device restarted, or a reading jumped


@dataclass(frozen=True, slots=True)
class Recording:
    """A drive, one row per SYNC; columns in the order of `vehicle.channels`.

    Methods that take a channel raise a `RecordingError` where the robot has none of that name.

    Attributes:
        vehicle: The nominal robot.
        time: Time of each SYNC on the recording's clock [s], shape `(N,)`.
        counts: Unwrapped raw counts, shape `(N, C)`; a sample that is not present repeats the one before.
        present: Whether the channel was read in this sample, shape `(N, C)`.
        poses: Absolute poses measured from outside, or None.
        run: What was driven, or None.
        gaps: Gaps of all channels, in order of time.
        commands: Commanded wheel speeds [rad/s], shape `(N, W)`, in the order of `vehicle.wheels`; or None.
        source: Where the recording came from, for messages.
    """

    vehicle: VehicleParameters
    time: Array
    counts: NDArray[np.int64]
    present: NDArray[np.bool_]
    poses: Poses | None = None
    run: Run | None = None
    gaps: tuple[Gap, ...] = ()
    commands: Array | None = None
    source: str = "recording"

    def __post_init__(self) -> None:
        shape = (len(self.time), len(self.vehicle.channels))
        if self.counts.shape != shape or self.present.shape != shape:
            raise ValueError(f"counts {self.counts.shape} and present {self.present.shape}; expected {shape}")
        wheels = (len(self.time), len(self.vehicle.wheels))
        if self.commands is not None and self.commands.shape != wheels:
            raise ValueError(f"commands {self.commands.shape}; expected {wheels}")
        if not np.isfinite(self.time).all():
            raise ValueError("time holds values that are not finite; expected seconds, one for each SYNC")
        if len(self.time) == 0:
            raise RecordingError(self.source, "no sample in it; expected SYNC frames (COB-ID 080h) and PDOs")
        _freeze(self.time, self.counts, self.present)
        if self.commands is not None:
            _freeze(self.commands)

    def __len__(self) -> int:
        return len(self.time)

    def is_present(self, channel: Channel) -> NDArray[np.bool_]:
        """Return where a channel was read, `(N,)`."""
        return self.present[:, self._column(channel)]

    def channel_counts(self, channel: Channel) -> NDArray[np.int64]:
        """Return the unwrapped counts of a channel, `(N,)`."""
        return self.counts[:, self._column(channel)]

    def wheel_angle(self, wheel: Channel) -> Array:
        """Return how far a wheel has turned [rad], `(N,)`; forward is positive, the zero is the counter's."""
        return np.asarray(self.channel_counts(wheel) * self.vehicle.encoder(wheel).scale, np.float64)

    def joint_angle(self, joint: Channel) -> Array:
        """Return a joint's angle [rad], `(N,)`: continuous, beginning in (-pi, pi]."""
        counts, encoder = self.channel_counts(joint), self.vehicle.encoder(joint)
        angle = (counts - encoder.zero) * encoder.scale
        return np.asarray(angle - (angle[0] - wrap(angle[0])), np.float64)

    def link_length(self) -> Array:
        """Return the distance of the trucks' centres [m], `(N,)`.

        Raises:
            RecordingError: the robot has one truck only.
        """
        if self.vehicle.linkage is None:
            raise RecordingError(self.source, "a robot with a single truck has no linkage")
        encoder = self.vehicle.encoder("link")
        length = self.vehicle.linkage.length + (self.channel_counts("link") - encoder.zero) * encoder.scale
        return np.asarray(length, np.float64)

    def _column(self, channel: Channel) -> int:
        channels = self.vehicle.channels
        if channel not in channels:
            raise RecordingError(self.source, f"no channel {channel}; the robot has {', '.join(channels)}")
        return channels.index(channel)

    def is_same_drive(self, other: Recording) -> bool:
        """Return whether another recording of this robot holds the same samples, poses and laps."""
        if self.vehicle != other.vehicle or self.run != other.run or len(self) != len(other):
            return False
        pairs = [(self.time, other.time), (self.counts, other.counts)]
        if self.poses is not None and other.poses is not None:
            pairs.append((self.poses.pose, other.poses.pose))
        same_kind = (self.poses is None) == (other.poses is None)
        return same_kind and all(np.array_equal(one, two, equal_nan=True) for one, two in pairs)

    def between(self, start: float, end: float) -> slice:
        """Return the slice of the samples with start <= time <= end [s]."""
        first = int(np.searchsorted(self.time, start, side="left"))
        return slice(first, int(np.searchsorted(self.time, end, side="right")))


def check_distinct(recordings: Sequence[Recording]) -> None:
    """Check that no drive is there twice, whose data would count double.

    Raises:
        RecordingError: Two recordings hold the same drive.
    """
    for first, second in itertools.combinations(recordings, 2):
        if first.is_same_drive(second):
            raise RecordingError(
                second.source, f"holds the same drive as {first.source}; give each drive once"
            )


def _freeze(*arrays: NDArray[np.generic]) -> None:
    for array in arrays:
        array.flags.writeable = False
