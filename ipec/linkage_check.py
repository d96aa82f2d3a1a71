"""Finds linkage channels that were never read, or that stand still while the trucks move."""

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

# A channel counts as frozen where it shows one value while the wheels say that it moves by more than this
# within a metre of the way, or in a turn on the spot, and by three times as much in all: a wheel that
# spins once is no frozen joint. A bump makes an error of 0.6 degrees and 2 mm.
JOINT_LIMIT = math.radians(5.0)  # [rad]
LINK_LIMIT = 0.03  # [m]


@dataclass(frozen=True, slots=True)
class FrozenChannel:
    """A stretch in which a channel stood still although it must have moved.

    Attributes:
        channel: Channel of the encoder.
        start: Time of the first sample of the stretch, on the recording's clock [s].
        end: Time of the last sample of the stretch, on the recording's clock [s].
        expected: How far the channel must have moved by plain odometry [rad] or [m].
    """

    channel: Channel
    start: float
    end: float
    expected: float


def frozen_channels(recording: Recording) -> tuple[FrozenChannel, ...]:
    """Return where channels of the linkage stood still although the trucks' wheels say otherwise.

    Only samples in which every encoder was read are compared. The expected motion of a channel follows from
    the joints, so that only the first channel to stop is reported, and the link only where both joints move.

    Raises:
        RecordingError: The two wheels of a truck are never present together.
    """
    joints, link, way = _expected(recording)
    whole = np.flatnonzero(recording.present.all(axis=1))
    if len(whole) == 0:
        return ()
    stretches = _frozen(recording, "joint_a", joints[0], JOINT_LIMIT, way, whole)
    stretches += _frozen(recording, "joint_b", joints[1], JOINT_LIMIT, way, whole)
    stretches = stretches or _frozen(recording, "link", link, LINK_LIMIT, way, whole)
    first = min(stretches, key=lambda stretch: stretch.start, default=None)
    return tuple(stretch for stretch in stretches if first and stretch.channel == first.channel)


def _expected(recording: Recording) -> tuple[tuple[Array, Array], Array, Array]:
    """Return how the joints [rad] and the link [m] must move by the wheels, and the way driven, each `(N,)`.

    The rates follow from rolling without slip: dl = v_A cos - v_B cos, l dtheta_L = v_A sin - v_B sin.
    """
    length = recording.link_length()[1:]
    turns, aheads, asides, ways = [], [], [], []
    pairs: tuple[tuple[TruckName, Channel], ...] = (("a", "joint_a"), ("b", "joint_b"))
    for truck, joint in pairs:
        left, right, _ = truck_travel(recording, truck)
        step = 0.5 * (np.diff(left) + np.diff(right))
        angle = recording.joint_angle(joint)[1:]
        turns.append((np.diff(right) - np.diff(left)) / recording.vehicle.trucks[truck].wheelbase)
        aheads.append(step * np.cos(angle))
        asides.append(step * np.sin(angle))
        ways.append(np.abs(step))
    swing = (asides[0] - asides[1]) / length
    joints = _summed(turns[0] - swing), _summed(turns[1] - swing)
    return joints, _summed(aheads[0] - aheads[1]), _summed(0.5 * (ways[0] + ways[1]))


def _summed(steps: Array) -> Array:
    return np.concatenate(([0.0], np.cumsum(steps)))


def _frozen(
    recording: Recording,
    channel: Channel,
    expected: Array,
    limit: float,
    way: Array,
    whole: NDArray[np.intp],
) -> list[FrozenChannel]:
    """Return the stretches of one count, within one metre of the way, in which it must have moved too far."""
    counts, time = recording.channel_counts(channel)[whole], recording.time[whole]
    expected, way = expected[whole], way[whole]
    first = np.concatenate(([0], np.flatnonzero(np.diff(counts) | np.diff(way.astype(np.int64))) + 1))
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
    """Refuse a recording whose linkage cannot correct anything.

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
            f"{in_words(frozen, float(recording.time[0]))}, and use plain odometry for this stretch",
        )


def in_words(frozen: FrozenChannel, first: float) -> str:
    """Return when a channel stood still, what was expected, and what to check; `first` is time 0 [s]."""
    amount = f"{math.degrees(frozen.expected):.1f} degrees"
    if frozen.channel == "link":
        amount = f"{1e3 * frozen.expected:.0f} mm"
    return (
        f"stands still from {frozen.start - first:.2f} to {frozen.end - first:.2f} s, while the wheels say "
        f"that it moved by {amount}; check its coupling and its node (is it operational, does its value "
        "change when it is moved by hand?)"
    )
