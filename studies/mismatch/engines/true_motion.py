"""How a drive in a contact engine differs from its odometry: nominal values, sizes of effects, clearness.

A robot has T trucks, one or two; a single truck has no joints and no link.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from studies.mismatch.engines.vocabulary import WHEELS

if TYPE_CHECKING:
    from numpy.typing import NDArray

WINDOW = 33  # rows of a stretch: about half a second


@dataclass(frozen=True, slots=True)
class Drive:
    """What happened in a drive, with a row for each SYNC."""

    time: NDArray[np.float64]  # time since the first SYNC [s], shape `(N,)`
    wheels: NDArray[np.float64]  # angles of the wheels [rad], shape `(N, 2 T)`
    joints: NDArray[np.float64]  # angles of both joints [rad], shape `(N, 2)`; zeros without a linkage
    link: NDArray[np.float64]  # length of the link [m], shape `(N,)`; zeros without a linkage
    poses: NDArray[np.float64]  # true poses of the trucks [m, m, rad], shape `(N, T, 3)`
    # contacts with obstacles, each as (obstacle, first row, last row)
    crossings: tuple[tuple[int, int, int], ...]


@dataclass(frozen=True, slots=True)
class Nominal:
    """The robot as its `vehicle.toml` describes it."""

    radii: NDArray[np.float64]  # rolling radii in the order of WHEELS [m], shape `(2 T,)`
    tracks: NDArray[np.float64]  # track of each truck [m], shape `(T,)`
    link: float  # length of the linkage at rest [m]; 0 without one


def motion(drive: Drive, rows: int = 1) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return how each truck moved over each stretch of rows, in the truck's frame.

    Args:
        drive: The drive, with N * rows + 1 rows or a few more.
        rows: Rows of one stretch.

    Returns:
        The true motion of the trucks, forward [m], sideways [m] and turn [rad], shape `(N, T, 3)`, and the
        turns of the wheels [rad], shape `(N, 2 T)`. Forward and sideways motion is summed row by row, so
        that it is exact in bends too.
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
    """Return the rolling radii, the tracks and the link's length at rest that explain a drive best.

    Radii and tracks are least squares over stretches of half a second of the true motion.

    Args:
        drive: A drive of a healthy robot.
        rest: Length of the link at which its encoder reads zero [m].
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
    return Nominal(radii, tracks, float(rest + np.mean(np.hypot(*apart.T) - drive.link)))


def residuals(drive: Drive, nominal: Nominal, rows: int = WINDOW) -> NDArray[np.float64]:
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
    turned = drive.joints - (drive.poses[:, :, 2] - bearing[:, None])
    joints = np.arctan2(np.sin(turned), np.cos(turned))
    linkage = np.column_stack([joints, drive.link - np.hypot(*apart.T)])[: len(moved) * rows]
    return np.column_stack([ways, moved[..., 1], linkage.reshape(-1, rows, 3).mean(axis=1)])


def above_noise(
    fault: NDArray[np.float64], healthy: NDArray[np.float64], floor: NDArray[np.float64]
) -> float:
    """Return by how many standard deviations a fault's residuals differ from the healthy robot's.

    Args:
        fault: Residuals of the robot with the fault, shape `(N, C)`.
        healthy: Residuals of the healthy robot on the same drive, shape `(M, C)`.
        floor: Standard deviations below which no sensor measures, shape `(C,)`.
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

    Args:
        touches: Whether each obstacle is touched in each row, shape `(N, O)`.
        apart: Rows without a touch after which the next one is another contact.
    """
    found: list[tuple[int, int, int]] = []
    for obstacle, column in enumerate(touches.T):
        rows = np.flatnonzero(column)
        if len(rows):
            parts = np.split(rows, np.flatnonzero(np.diff(rows) > apart) + 1)
            found.extend((obstacle, int(part[0]), int(part[-1]) + 1) for part in parts)
    return tuple(sorted(found, key=lambda contact: contact[1]))


def crossings(
    drive: Drive, nominal: Nominal, wheel: str, start: float
) -> tuple[list[list[float]], list[float]]:
    """Return the intervals of contact with cables [s], and distances rolled minus travelled in them [m]."""
    column = WHEELS.index(wheel)
    left = -residuals(drive, nominal, 1)[:, column] * np.sign(np.diff(drive.wheels[:, column]))
    spans = [(first, last) for _, first, last in drive.crossings]
    times = [[float(drive.time[a] + start), float(drive.time[min(b, len(left))] + start)] for a, b in spans]
    return times, [float(left[max(0, a - 14) : b + 14].sum()) for a, b in spans]


def lost_in(drive: Drive, nominal: Nominal, wheel: str, span: tuple[float, float]) -> tuple[float, float]:
    """Return the distances [m] that a wheel rolled and lost in a span of the drive's time [s]."""
    rows = (drive.time[1:] >= span[0]) & (drive.time[1:] < span[1])
    column = WHEELS.index(wheel)
    left = -residuals(drive, nominal, 1)[rows, column]
    rolled = motion(drive)[1][rows, column] * nominal.radii[column]
    return float(np.abs(rolled).sum()), float(left.sum())


def rolling_ratios(drive: Drive, nominal: Nominal, wheel: str, time: float) -> tuple[float, float]:
    """Return a wheel's rolling radius before and after a time, each over its nominal radius."""
    moved, wheels = motion(drive, 66)
    column = WHEELS.index(wheel)
    truck, side = column // 2, 1 if column % 2 else -1
    way = moved[:, truck, 0] + side * moved[:, truck, 2] * nominal.tracks[truck] / 2
    rolled, late = wheels[:, column], (np.arange(len(way)) + 0.5) * 66 * drive.time[1] > time
    before, after = (
        float(way[at] @ rolled[at] / (rolled[at] @ rolled[at]) / nominal.radii[column])
        for at in (~late, late)
    )
    return before, after


def creep(drive: Drive) -> NDArray[np.float64]:
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


def _reckoned(drive: Drive, nominal: Nominal) -> NDArray[np.float64]:
    """Return the sum of truck a's true steps less what its wheels rolled along its true heading."""
    theta = drive.poses[:-1, 0, 2] + np.diff(np.unwrap(drive.poses[:, 0, 2])) / 2
    rolled = (motion(drive)[1][:, :2] * nominal.radii[:2]).mean(axis=1)
    step = np.diff(drive.poses[:, 0, :2], axis=0)
    return np.asarray((step - rolled[:, None] * np.stack([np.cos(theta), np.sin(theta)], axis=1)).sum(axis=0))


def kicks(drive: Drive, nominal: Nominal, truck: int) -> NDArray[np.float64]:
    """Return a truck's yaw in 1.5 s after each reversal, less that of its wheels [rad], shape `(R,)`."""
    left = residuals(drive, nominal, 1)[:, 2 * truck : 2 * truck + 2]
    yaw = np.concatenate([[0.0], np.cumsum(left[:, 1] - left[:, 0]) / nominal.tracks[truck]])
    rate = np.diff(drive.wheels[:, 2 * truck])
    moving = np.flatnonzero(np.abs(rate) > 0.02 * np.abs(rate).max())
    turned = np.flatnonzero(np.diff(np.sign(rate[moving])))
    after = moving[turned + 1]
    return np.asarray(yaw[np.minimum(after + 100, len(yaw) - 1)] - yaw[after])
