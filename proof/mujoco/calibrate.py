"""How a MuJoCo drive differs from its odometry: calibrated nominal values, and how clear a fault is."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.proof.mujoco.control import Nominal

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.proof.mujoco.drive import Drive

WINDOW = 33  # rows of a stretch: half a second


def motion(drive: Drive, rows: int = 1) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return how each truck moved over each stretch of rows, in the truck's frame.

    Args:
        drive: The drive, with N * rows + 1 rows or a few more.
        rows: Rows of one stretch.

    Returns:
        The true motion of both trucks, forward [m], sideways [m] and turn [rad], shape `(N, 2, 3)`, and the
        turns of the four wheels [rad], shape `(N, 4)`. Forward and sideways motion is summed row by row, so
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
        moved[:n].reshape(-1, rows, 2, 3).sum(axis=1),
        np.diff(drive.wheels, axis=0)[:n].reshape(-1, rows, 4).sum(axis=1),
    )


def calibrate(drive: Drive, rest: float) -> Nominal:
    """Return the rolling radii, the tracks and the link's length at rest that explain a drive best.

    Radii and tracks are least squares over stretches of half a second of the true motion.

    Args:
        drive: A drive of a healthy robot.
        rest: Length of the link at which its encoder reads zero [m].
    """
    moved, wheels = motion(drive, WINDOW)
    radii, tracks = np.empty(4), np.empty(2)
    for i in range(2):
        both = wheels[:, 2 * i : 2 * i + 2]
        mean = np.linalg.lstsq(both.sum(axis=1)[:, None] / 2, moved[:, i, 0], rcond=None)[0][0]
        q, p = np.linalg.lstsq(both, moved[:, i, 2], rcond=None)[0]
        tracks[i] = 2 * mean / (p - q)
        radii[2 * i : 2 * i + 2] = -q * tracks[i], p * tracks[i]
    apart = drive.poses[:, 0, :2] - drive.poses[:, 1, :2]
    return Nominal(radii, tracks, float(rest + np.mean(np.hypot(*apart.T) - drive.link)))


def residuals(drive: Drive, nominal: Nominal, rows: int = WINDOW) -> NDArray[np.float64]:
    """Return what the nominal robot does not explain over stretches of rows, shape `(N, 9)`.

    The columns are the distance travelled minus the distance rolled of the four wheels [m], the sideways
    motion of trucks a and b [m], and readings minus truth of joint_a [rad], joint_b [rad] and link [m].
    """
    moved, wheels = motion(drive, rows)
    half = nominal.tracks / 2
    left, right = moved[..., 0] - moved[..., 2] * half, moved[..., 0] + moved[..., 2] * half
    rolled = wheels * nominal.radii
    ways = np.stack([left[:, 0], right[:, 0], left[:, 1], right[:, 1]], axis=1) - rolled
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
