"""Open loop: a robot with given effects, driven by recorded wheels, against the poses that were measured."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.effects.ageing import AgedSamples
from omnimate.effects.block import Block
from omnimate.effects.reference_offset import truck_poses
from omnimate.effects.stages import replay
from omnimate.vehicle.arcs import integrate_twists
from omnimate.vehicle.se2 import between
from studies.mismatch.engines.strength.drive import rates

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.effects.effect import Effect
    from omnimate.vehicle.parameters import Channel
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array

STRETCH = 10.0  # [s] that is driven open loop
_WHEELS: tuple[Channel, Channel] = ("a.left", "a.right")


def position_error(recordings: Sequence[Recording], effects: Sequence[Effect] = ()) -> float:
    """Return the position error of truck a after 10 s of open loop, root mean square [m].

    Args:
        recordings: Recordings with dense poses of truck a, headings among them, of a robot as described.
        effects: Physics that the description leaves out.
    """
    return float(np.sqrt(np.mean(np.concatenate([_errors(each, effects) for each in recordings]) ** 2)))


def _errors(recording: Recording, effects: Sequence[Effect]) -> Array:
    """Return the position error at the end of each stretch of one recording [m], shape `(S,)`."""
    time, measured = recording.time, _measured(recording, effects)
    twist = replay(block_of(recording), effects).twist[:, 0]
    heading = np.concatenate(([0.0], np.cumsum(twist[:, 2])))
    path = integrate_twists(twist, heading, np.zeros(3))
    edges = np.linspace(0, len(time) - 1, max(1, round(float(time[-1] - time[0]) / STRETCH)) + 1).astype(int)
    begin, end = edges[:-1], edges[1:]
    off = between(path[begin], path[end]) - between(measured[begin], measured[end])
    return np.asarray(np.hypot(off[:, 0], off[:, 1]))


def _measured(recording: Recording, effects: Sequence[Effect]) -> Array:
    """Return truck a's pose at every sample `(N, 3)`: stamps and the reference's place put right."""
    assert recording.poses is not None  # the caller chose recordings with poses
    poses = recording.poses.of("a")
    known = np.isfinite(poses.pose).all(axis=1)
    time, pose = poses.time[known], poses.pose[known].copy()
    for effect in effects:
        if isinstance(effect, AgedSamples) and effect.acts_at() == "poses":
            time = time - effect.age(time, float(recording.time[0]))
    pose = truck_poses(effects, "a", pose)
    pose[:, 2] = np.unwrap(pose[:, 2])
    return np.stack([np.interp(recording.time, time, axis) for axis in pose.T], axis=1)


def block_of(recording: Recording) -> Block:
    """Return the steps of a recording of a single truck, as its nominal robot would have driven them."""
    vehicle, time = recording.vehicle, np.asarray(recording.time)
    angle = np.stack([recording.wheel_angle(wheel) for wheel in _WHEELS], axis=1)
    radius = np.array([0.5 * vehicle.wheel_diameter(wheel) for wheel in _WHEELS])
    turned = np.diff(angle, axis=0)
    smooth = [rates(way, time) for way in (radius * angle).T]
    pose = _measured(recording, ()) if recording.poses is not None else np.zeros((len(time), 3))
    middle = 0.5 * (pose[1:] + pose[:-1])
    return Block(
        time=time[1:],
        period=np.diff(time),
        angle=angle[1:],
        turned=turned,
        speed=np.stack([speed for speed, _ in smooth], axis=1),
        acceleration=np.stack([acceleration for _, acceleration in smooth], axis=1),
        wheelbase=np.array([vehicle.trucks["a"].wheelbase]),
        heading=middle[:, None, 2],
        place=middle[:, None, :2],
        travel=radius * turned,
        twist=np.zeros((len(turned), 1, 3)),
        reading=np.zeros((len(turned), 0)),
    ).rolled()
