"""How a drive in a contact engine differs from its odometry: nominal values, sizes of effects, clearness.

A robot has T trucks, one or two; a single truck has no joints and no link.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from studies.mismatch.engines.vocabulary import JOINTS, TRUCKS, WHEELS, Array

WINDOW = 33  # rows of a stretch: about half a second


@dataclass(frozen=True, slots=True)
class Drive:
    """What happened in a drive, with a row for each SYNC."""

    time: Array  # time since the first SYNC [s], shape `(N,)`
    wheels: Array  # angles of the wheels [rad], shape `(N, 2 T)`
    # angles of both joints [rad] and length of the link [m], shape `(N, 3)`; zeros without a linkage
    linkage: Array
    poses: Array  # true poses of the trucks [m, m, rad], shape `(N, T, 3)`
    # contacts with obstacles, each as (obstacle, first row, last row)
    crossings: tuple[tuple[int, int, int], ...]


@dataclass(frozen=True, slots=True)
class Nominal:
    """The robot as its `vehicle.toml` describes it."""

    radii: Array  # rolling radii in the order of WHEELS [m], shape `(2 T,)`
    tracks: Array  # track of each truck [m], shape `(T,)`
    link: float  # length of the linkage at rest [m]; 0 without one


def motion(drive: Drive, rows: int = 1) -> tuple[Array, Array]:
    """Return how the trucks moved over each stretch of rows, and the turns of the wheels [rad] `(N, 2 T)`.

    The motion is forward [m], sideways [m] and turn [rad] in the truck's frame, shape `(N, T, 3)`, summed row
    by row, so that it is exact in bends too.
    """
    poses = drive.poses.copy()
    poses[:, :, 2] = np.unwrap(poses[:, :, 2], axis=0)
    step = np.diff(poses, axis=0)
    middle = poses[:-1, :, 2] + step[:, :, 2] / 2
    c, s = np.cos(middle), np.sin(middle)
    moved = np.stack(
        [c * step[..., 0] + s * step[..., 1], c * step[..., 1] - s * step[..., 0], step[..., 2]], axis=-1
    )
    n = len(moved) // rows * rows
    return (
        moved[:n].reshape(-1, rows, *moved.shape[1:]).sum(axis=1),
        np.diff(drive.wheels, axis=0)[:n].reshape(-1, rows, drive.wheels.shape[1]).sum(axis=1),
    )


def calibrate(drive: Drive, rest: float) -> Nominal:
    """Return the rolling radii, the tracks and the link's length at rest that explain a healthy drive best.

    Radii and tracks are least squares over stretches of half a second of the true motion; `rest` is the
    length of the link at which its encoder reads zero [m].
    """
    moved, wheels = motion(drive, WINDOW)
    trucks = drive.poses.shape[1]
    radii, tracks = np.empty(2 * trucks), np.empty(trucks)
    for i in range(trucks):
        both = wheels[:, 2 * i : 2 * i + 2]
        mean = np.linalg.lstsq(both.sum(axis=1)[:, None] / 2, moved[:, i, 0], rcond=None)[0][0]
        q, p = np.linalg.lstsq(both, moved[:, i, 2], rcond=None)[0]
        tracks[i] = 2 * mean / (p - q)
        radii[2 * i : 2 * i + 2] = -q * tracks[i], p * tracks[i]
    if trucks == 1:
        return Nominal(radii, tracks, 0.0)
    apart = drive.poses[:, 0, :2] - drive.poses[:, 1, :2]
    return Nominal(radii, tracks, float(rest + np.mean(np.hypot(*apart.T) - drive.linkage[:, 2])))


def residuals(drive: Drive, nominal: Nominal, rows: int = WINDOW) -> Array:
    """Return what the nominal robot does not explain over stretches of rows, shape `(N, 9)`.

    The columns are the distance travelled minus the distance rolled of the four wheels [m], the sideways
    motion of trucks a and b [m], and readings minus truth of joint_a [rad], joint_b [rad] and link [m].
    Of a single truck they are those of its two wheels and its sideways motion, shape `(N, 3)`.
    """
    moved, wheels = motion(drive, rows)
    half = nominal.tracks / 2
    left, right = moved[..., 0] - moved[..., 2] * half, moved[..., 0] + moved[..., 2] * half
    rolled = wheels * nominal.radii
    ways = np.stack([left, right], axis=2).reshape(len(rolled), -1) - rolled
    if drive.poses.shape[1] == 1:
        return np.column_stack([ways, moved[..., 1]])
    apart = drive.poses[:, 0, :2] - drive.poses[:, 1, :2]
    bearing = np.arctan2(apart[:, 1], apart[:, 0])
    turned = drive.linkage[:, :2] - (drive.poses[:, :, 2] - bearing[:, None])
    joints = np.arctan2(np.sin(turned), np.cos(turned))
    linkage = np.column_stack([joints, drive.linkage[:, 2] - np.hypot(*apart.T)])[: len(moved) * rows]
    return np.column_stack([ways, moved[..., 1], linkage.reshape(-1, rows, 3).mean(axis=1)])


def above_noise(fault: Array, healthy: Array, floor: Array) -> float:
    """Return by how many standard deviations a fault's residuals `(N, C)` differ from the healthy robot's.

    `floor` `(C,)` are standard deviations below which no sensor measures.
    """
    n = min(len(fault), len(healthy))
    sigma = np.hypot(healthy.std(axis=0), floor)
    z = (fault[:n] - healthy[:n].mean(axis=0)) / sigma
    return float(
        np.sqrt(
            max(0.0, float((z**2).sum()) - float((((healthy - healthy.mean(axis=0)) / sigma) ** 2).sum()))
        )
    )


def contacts(touches: NDArray[np.bool_], apart: int) -> tuple[tuple[int, int, int], ...]:
    """Return the contacts with obstacles, each as (obstacle, first row, last row), in order of time.

    `touches` has a column for each obstacle, shape `(N, O)`; `apart` rows without a touch end a contact.
    """
    touching: list[tuple[int, int, int]] = []
    for obstacle, column in enumerate(touches.T):
        rows = np.flatnonzero(column)
        if len(rows):
            parts = np.split(rows, np.flatnonzero(np.diff(rows) > apart) + 1)
            touching.extend((obstacle, int(part[0]), int(part[-1]) + 1) for part in parts)
    return tuple(sorted(touching, key=lambda contact: contact[1]))


def crossings(
    drive: Drive, nominal: Nominal, wheel: str, start: float
) -> tuple[list[list[float]], list[float]]:
    """Return the intervals of contact with cables [s], and distances rolled minus travelled in them [m]."""
    column = WHEELS.index(wheel)
    left = -residuals(drive, nominal, 1)[:, column] * np.sign(np.diff(drive.wheels[:, column]))
    spans = [(first, last) for _, first, last in drive.crossings]
    times = [[float(drive.time[a] + start), float(drive.time[min(b, len(left))] + start)] for a, b in spans]
    return times, [float(left[max(0, a - 14) : b + 14].sum()) for a, b in spans]


def rolling_ratios(drive: Drive, nominal: Nominal, wheel: str, time: float) -> tuple[float, float]:
    """Return a wheel's rolling radius before and after a time [s], each over its nominal radius."""
    before, after = (
        rolling_radius(drive, nominal, wheel, rows) / float(nominal.radii[WHEELS.index(wheel)])
        for rows in before_and_after(time, drive)
    )
    return before, after


def creep(drive: Drive) -> Array:
    """Return each truck's sideways speed over its centripetal acceleration [s], shape `(2,)`."""
    moved, _ = motion(drive, 33)
    seconds = 33 * drive.time[1]
    pull = moved[..., 0] * moved[..., 2] / seconds**2
    return np.asarray(-(pull * moved[..., 1] / seconds).sum(axis=0) / (pull**2).sum(axis=0))


def downhill(drive: Drive, nominal: Nominal, healthy: Drive) -> float:
    """Return truck a's creep down the tilt per metre travelled, less that on the level floor."""
    drift = np.hypot(*(_reckoned(drive, nominal) - _reckoned(healthy, nominal)))
    moved, _ = motion(drive)
    return float(drift / np.abs(moved[:, 0, 0]).sum())


def _reckoned(drive: Drive, nominal: Nominal) -> Array:
    """Return the sum of truck a's true steps less what its wheels rolled along its true heading."""
    theta = drive.poses[:-1, 0, 2] + np.diff(np.unwrap(drive.poses[:, 0, 2])) / 2
    rolled = (motion(drive)[1][:, :2] * nominal.radii[:2]).mean(axis=1)
    step = np.diff(drive.poses[:, 0, :2], axis=0)
    return np.asarray((step - rolled[:, None] * np.stack([np.cos(theta), np.sin(theta)], axis=1)).sum(axis=0))


def kicks(drive: Drive, nominal: Nominal, truck: int) -> Array:
    """Return a truck's yaw in 1.5 s after each reversal, less that of its wheels [rad], shape `(R,)`."""
    left = residuals(drive, nominal, 1)[:, 2 * truck : 2 * truck + 2]
    yaw = np.concatenate([[0.0], np.cumsum(left[:, 1] - left[:, 0]) / nominal.tracks[truck]])
    rate = np.diff(drive.wheels[:, 2 * truck])
    moving = np.flatnonzero(np.abs(rate) > 0.02 * np.abs(rate).max())
    turned = np.flatnonzero(np.diff(np.sign(rate[moving])))
    after = moving[turned + 1]
    return np.asarray(yaw[np.minimum(after + 100, len(yaw) - 1)] - yaw[after])


def rolling_radius(drive: Drive, nominal: Nominal, wheel: str, rows: slice = slice(None)) -> float:
    """Return the radius on which a wheel rolled [m], in some of the windows of a drive."""
    column = WHEELS.index(wheel)
    turned = motion(drive, WINDOW)[1][rows, column]
    travelled = residuals(drive, nominal)[rows, column] + turned * nominal.radii[column]
    return float(travelled @ turned / (turned @ turned))


def before_and_after(time: float, drive: Drive) -> tuple[slice, slice]:
    """Return the windows of a drive that end before a time [s], and those that begin after it."""
    row = time / (drive.time[1] * WINDOW)
    return slice(int(row)), slice(int(np.ceil(row)), None)


def turning_base(drive: Drive, nominal: Nominal, truck: int) -> float:
    """Return the wheelbase on which a truck turned [m]."""
    moved, turned = motion(drive, WINDOW)
    left, right = (turned * nominal.radii)[:, 2 * truck : 2 * truck + 2].T
    yaw = moved[:, truck, 2]
    return float((right - left) @ yaw / (yaw @ yaw))


def travel_angle(drive: Drive, truck: int) -> float:
    """Return the angle of a truck's travel to its own straight ahead, where it does not turn [rad]."""
    forward, aside, yaw = motion(drive, WINDOW)[0][:, truck].T
    straight = np.abs(yaw) < np.quantile(np.abs(yaw), 0.5) + 1e-9
    return float(aside[straight] @ forward[straight] / (forward[straight] @ forward[straight]))


def wave(drive: Drive, nominal: Nominal, wheel: str) -> tuple[float, float]:
    """Return amplitude [m] and phase [rad] of a wheel's rolling radius over its angle."""
    column = WHEELS.index(wheel)
    turned = np.diff(drive.wheels[:, column])
    angle = drive.wheels[:-1, column] + 0.5 * turned
    columns = turned[:, None] * np.stack([np.cos(angle), -np.sin(angle), np.ones_like(angle)], axis=1)
    even, odd, _ = np.linalg.lstsq(columns, residuals(drive, nominal, 1)[:, column], rcond=None)[0]
    return float(np.hypot(even, odd)), float(np.arctan2(odd, even))


def lost(drive: Drive, nominal: Nominal, wheel: str, inside: NDArray[np.bool_]) -> float:
    """Return the share of the rolled way that a wheel lost in some rows; 0 where it did not roll."""
    column = WHEELS.index(wheel)
    rows = inside[1:]
    rolled = motion(drive)[1][rows, column] * nominal.radii[column]
    missed = -residuals(drive, nominal, 1)[rows, column] * np.sign(rolled)
    whole = float(np.abs(rolled).sum())
    return float(missed.sum()) / whole if whole else 0.0


def axle_ahead(drive: Drive) -> Array:
    """Return how far ahead of each truck's origin it turns without moving sideways [m], shape `(T,)`."""
    _, aside, yaw = np.moveaxis(motion(drive, WINDOW)[0], -1, 0)
    return np.asarray(-(aside * yaw).sum(axis=0) / np.maximum((yaw**2).sum(axis=0), 1e-12))


def path_of(drive: Drive, tracks: Array, wheel: str) -> Array:
    """Return where a wheel is on the floor [m], shape `(N, 2)`."""
    truck = WHEELS.index(wheel) // 2
    x, y, heading = drive.poses[:, truck].T
    half = 0.5 * tracks[truck] * (1.0 if wheel.endswith("left") else -1.0)
    return np.stack([x - half * np.sin(heading), y + half * np.cos(heading)], axis=1)


@dataclass(frozen=True, slots=True)
class Draws:
    """What a fault is drawn for: a robot with contacts, and its healthy drive of the programme."""

    chance: np.random.Generator  # source of all that is drawn
    nominal: Nominal  # the robot as `vehicle.toml` describes it
    healthy: Drive  # the healthy robot's drive
    start: float  # time of the first SYNC [s]

    def sign(self) -> float:
        """Return +1 or -1, drawn at random."""
        return float(self.chance.choice([-1.0, 1.0]))

    def wheel(self) -> str:
        return str(self.chance.choice(WHEELS[: len(self.nominal.radii)]))

    def truck(self) -> str:
        return str(self.chance.choice(TRUCKS[: len(self.nominal.tracks)]))

    def joint(self) -> str:
        return str(self.chance.choice(JOINTS))

    def moment(self, first: float, last: float) -> float:
        """Return a time of the drive [s] between two shares of its duration, drawn at random."""
        return float(self.healthy.time[-1] * self.chance.uniform(first, last))
