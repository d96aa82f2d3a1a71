"""Where a MuJoCo drive and its own odometry part: a robot's nominal values, and how clear a fault is."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from proof.mujoco_control import Nominal

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from proof.mujoco_drive import Drive

WINDOW = 33  # rows, half a second


def motion(drive: Drive, rows: int = 1) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return what each truck did over each stretch of rows, in its own frame.

    Returns:
        Forward, sideways [m] and turn [rad], shape (N, 2, 3), of the true poses; wheel angles [rad], shape
        (N, 4). The forward and sideways ways are summed row by row, so that bends cost nothing.
    """
    poses = drive.poses.copy()
    poses[:, :, 2] = np.unwrap(poses[:, :, 2], axis=0)
    step = np.diff(poses, axis=0)
    middle = poses[:-1, :, 2] + step[:, :, 2] / 2
    c, s = np.cos(middle), np.sin(middle)
    own = np.stack(
        [c * step[..., 0] + s * step[..., 1], c * step[..., 1] - s * step[..., 0], step[..., 2]], axis=-1
    )
    n = len(own) // rows * rows
    return (
        own[:n].reshape(-1, rows, 2, 3).sum(axis=1),
        np.diff(drive.wheels, axis=0)[:n].reshape(-1, rows, 4).sum(axis=1),
    )


def calibrate(drive: Drive, rest: float) -> Nominal:
    """Return the rolling radii and tracks that explain a drive best, and the link's length at rest."""
    own, wheels = motion(drive, WINDOW)
    radii, tracks = np.empty(4), np.empty(2)
    for i in range(2):
        both = wheels[:, 2 * i : 2 * i + 2]
        mean = np.linalg.lstsq(both.sum(axis=1)[:, None] / 2, own[:, i, 0], rcond=None)[0][0]
        q, p = np.linalg.lstsq(both, own[:, i, 2], rcond=None)[0]
        tracks[i] = 2 * mean / (p - q)
        radii[2 * i : 2 * i + 2] = -q * tracks[i], p * tracks[i]
    apart = drive.poses[:, 0, :2] - drive.poses[:, 1, :2]
    return Nominal(radii, tracks, float(rest + np.mean(np.hypot(*apart.T) - drive.link)))


def residuals(drive: Drive, nominal: Nominal, rows: int = WINDOW) -> NDArray[np.float64]:
    """Return what the nominal robot leaves over stretches of rows, shape (N, 9).

    Columns: travelled minus rolled way of the four wheels, sideways ways of a and b [m], readings minus truth
    of joint_a, joint_b [rad] and link [m].
    """
    own, wheels = motion(drive, rows)
    half = nominal.tracks / 2
    left, right = own[..., 0] - own[..., 2] * half, own[..., 0] + own[..., 2] * half
    rolled = wheels * nominal.radii
    ways = np.stack([left[:, 0], right[:, 0], left[:, 1], right[:, 1]], axis=1) - rolled
    apart = drive.poses[:, 0, :2] - drive.poses[:, 1, :2]
    bearing = np.arctan2(apart[:, 1], apart[:, 0])
    turned = drive.joints - (drive.poses[:, :, 2] - bearing[:, None])
    joints = np.arctan2(np.sin(turned), np.cos(turned))
    linkage = np.column_stack([joints, drive.link - np.hypot(*apart.T)])[: len(own) * rows]
    return np.column_stack([ways, own[..., 1], linkage.reshape(-1, rows, 3).mean(axis=1)])


def above_noise(
    fault: NDArray[np.float64], healthy: NDArray[np.float64], floor: NDArray[np.float64]
) -> float:
    """Return by how many standard deviations a fault's residuals differ from the healthy robot's.

    Args:
        fault: residuals, shape (N, C).
        healthy: those of the healthy robot on the same drive.
        floor: standard deviations below which nobody measures, shape (C,).
    """
    n = min(len(fault), len(healthy))
    sigma = np.hypot(healthy.std(axis=0), floor)
    z = (fault[:n] - healthy[:n].mean(axis=0)) / sigma
    return float(
        np.sqrt(
            max(0.0, float((z**2).sum()) - float((((healthy - healthy.mean(axis=0)) / sigma) ** 2).sum()))
        )
    )
