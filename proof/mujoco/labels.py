"""Labels of a MuJoCo drive: values where the geometry or the true poses give them, else None."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from omnimate.proof.mujoco.calibrate import motion, residuals
from omnimate.proof.mujoco.robot import WHEELS

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from omnimate.proof.mujoco.control import Nominal
    from omnimate.proof.mujoco.drive import Drive

UNITS = {
    "ratio": "1", "amplitude": "m", "phase": "rad", "angle": "rad", "bias": "m", "lost": "m", "times": "s",
    "time": "s", "compliance": "s", "rate": "1", "direction": "rad", "fraction": "1", "yaw": "rad",
}  # fmt: skip


def label(
    effect: str,
    component: str,
    values: dict[str, Any],
    acceptable: tuple[tuple[str, str], ...] = (),
    intervals: list[list[float]] | None = None,
) -> dict[str, Any]:
    """Return the label of an effect as `labels.json` holds it; amplitudes and biases of joints are angles."""
    units = UNITS | ({"amplitude": "rad", "bias": "rad"} if component.startswith("joint") else {})
    return {
        "effect": effect,
        "component": component,
        "parameters": {name: {"value": value, "unit": units[name]} for name, value in values.items()},
        "intervals": intervals or [],
        "acceptable": [
            {"effect": name, "component": where, "by_judgement": True} for name, where in acceptable
        ],
    }


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
