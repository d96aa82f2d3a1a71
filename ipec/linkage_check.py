"""Find linkage channels that were never read, or that stand still while the trucks move."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.ipec.errors import LinkageChannelError, NoLinkageError
from omnimate.vehicle.odometry import truck_travel
from omnimate.vehicle.parameters import CHANNELS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.vehicle.parameters import Channel, TruckName
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array

LINKAGE: tuple[Channel, ...] = CHANNELS[4:]

# A channel is frozen if its count is constant while odometry expects it to move by more than the limit within
# one metre or in a turn on the spot, and by three limits in total, so that one spin of a wheel is not
# reported. Assumption: eight times what a bump causes, 0.6 degrees (C 6.1), and fifteen times its 2 mm.
JOINT_LIMIT = math.radians(5.0)  # [rad]
LINK_LIMIT = 0.03  # [m]


@dataclass(frozen=True, slots=True)
class FrozenChannel:
    """An interval in which a channel read a constant although odometry says that it moved."""

    channel: Channel  # channel of the encoder
    start: float  # time of the first sample of the interval, on the recording's clock [s]
    end: float  # time of the last sample of the interval, on the recording's clock [s]
    expected: float  # motion of the channel in it by odometry [rad] or [m]


def frozen_channels(recording: Recording) -> tuple[FrozenChannel, ...]:
    """Return the intervals in which linkage channels were frozen although the wheels turned.

    Only samples in which every encoder was read are compared. The expected motion of a channel follows from
    the joints, so that only the first channel to stop is reported, and the link only where both joints move.

    Raises:
        RecordingError: The two wheels of a truck are never present together.
    """
    joints, link, distance = _expected_motion(recording)
    whole = np.flatnonzero(recording.present.all(axis=1))
    if len(whole) == 0:
        return ()
    stretches = _frozen_stretches(recording, "joint_a", joints[0], JOINT_LIMIT, distance, whole)
    stretches += _frozen_stretches(recording, "joint_b", joints[1], JOINT_LIMIT, distance, whole)
    stretches = stretches or _frozen_stretches(recording, "link", link, LINK_LIMIT, distance, whole)
    first = min(stretches, key=lambda stretch: stretch.start, default=None)
    return tuple(stretch for stretch in stretches if first and stretch.channel == first.channel)


def _expected_motion(recording: Recording) -> tuple[tuple[Array, Array], Array, Array]:
    """Return motion of joints [rad] and link [m] by the wheels, and distance driven [m], `(N,)` arrays.

    The rates follow from rolling without slip: dl = v_A cos - v_B cos, l dtheta_L = v_A sin - v_B sin.
    """
    length = recording.link_length()[1:]
    turns, aheads, asides, distances = [], [], [], []
    pairs: tuple[tuple[TruckName, Channel], ...] = (("a", "joint_a"), ("b", "joint_b"))
    for truck, joint in pairs:
        left, right, _ = truck_travel(recording, truck)
        step = 0.5 * (np.diff(left) + np.diff(right))
        angle = recording.joint_angle(joint)[1:]
        turns.append((np.diff(right) - np.diff(left)) / recording.vehicle.trucks[truck].wheelbase)
        aheads.append(step * np.cos(angle))
        asides.append(step * np.sin(angle))
        distances.append(np.abs(step))
    swing = (asides[0] - asides[1]) / length
    joints = _cumulative(turns[0] - swing), _cumulative(turns[1] - swing)
    return joints, _cumulative(aheads[0] - aheads[1]), _cumulative(0.5 * (distances[0] + distances[1]))


def _cumulative(steps: Array) -> Array:
    return np.concatenate(([0.0], np.cumsum(steps)))


def _frozen_stretches(
    recording: Recording,
    channel: Channel,
    expected: Array,
    limit: float,
    distance: Array,
    whole: NDArray[np.intp],
) -> list[FrozenChannel]:
    """Return the runs of a constant count, cut at every metre, whose expected motion exceeds `limit`."""
    counts, time = recording.channel_counts(channel)[whole], recording.time[whole]
    expected, distance = expected[whole], distance[whole]
    first = np.concatenate(([0], np.flatnonzero(np.diff(counts) | np.diff(distance.astype(np.int64))) + 1))
    last = np.append(first[1:], len(counts)) - 1
    moved = np.maximum.reduceat(expected, first) - np.minimum.reduceat(expected, first)
    bad = np.flatnonzero(moved > limit)
    if moved[bad].sum() < 3.0 * limit:
        return []
    return [
        FrozenChannel(channel, float(time[first[k]]), float(time[last[k]]), float(moved[k]))
        for k in bad.tolist()
    ]


def check_linkage(recording: Recording) -> None:
    """Raise an error if the linkage of a recording was not read, or was frozen.

    Raises:
        NoLinkageError: The robot has a single truck.
        LinkageChannelError: A channel was never read, or stood still while it must move.
    """
    vehicle = recording.vehicle
    if vehicle.linkage is None:
        raise NoLinkageError(recording.source)
    for channel in LINKAGE:
        if not recording.is_present(channel).any():
            raise LinkageChannelError(
                recording.source,
                channel,
                vehicle.encoder(channel).node,
                "was never read; check that the node answers SYNC, and its cob_id in vehicle.toml",
            )
    for frozen in frozen_channels(recording)[:1]:
        raise LinkageChannelError(
            recording.source,
            frozen.channel,
            vehicle.encoder(frozen.channel).node,
            describe_frozen_channel(frozen, float(recording.time[0]))
            + ", and use plain odometry for this stretch",
        )


def describe_frozen_channel(frozen: FrozenChannel, first: float) -> str:
    """Return a sentence: when a channel was frozen, what to check; `first` is the time of the start [s]."""
    amount = f"{math.degrees(frozen.expected):.1f} degrees"
    if frozen.channel == "link":
        amount = f"{1e3 * frozen.expected:.0f} mm"
    return (
        f"stands still from {frozen.start - first:.2f} to {frozen.end - first:.2f} s, while the wheels say "
        f"that it moved by {amount}; check its coupling and its node (is it operational, does its value "
        "change when it is moved by hand?)"
    )
