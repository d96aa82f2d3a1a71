"""Recording folders, written from their specification alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from studies.mismatch.engines.robots import toml_of

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from numpy.random import Generator
    from numpy.typing import NDArray

    from studies.mismatch.engines.engine import Drive
    from studies.mismatch.engines.robots import Robot

    Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Measuring:
    """How poses are measured from outside.

    Attributes:
        sigma: Standard deviations that are stated: x, y [m] and heading [rad].
        period: Time between two poses [s]; 0 for poses at the stops alone.
        both: Whether every truck is measured, or truck a alone.
        noise: Factor by which they scatter more than they state.
        lever: Place of the markers on the truck, which is believed to be its centre: forward and left [m].
        delay: Time by which the stamps are late [s].
        fast: Rate by which the clock of the stamps runs fast.
        outliers: Share of poses that are ten times as far off.
    """

    sigma: tuple[float, float, float]
    period: float
    both: bool
    noise: float = 1.0
    lever: tuple[float, float] = (0.0, 0.0)
    delay: float = 0.0
    fast: float = 0.0
    outliers: float = 0.0


SONAR = Measuring((0.002, 0.002, 0.004), 0.0, both=False)
MOCAP = Measuring((0.001, 0.001, 0.0015), 0.05, both=True)
MEASURING = {"none": None, "sonar": SONAR, "mocap": MOCAP}


def write(
    folder: Path, robot: Robot, drive: Drive, measuring: Measuring | None, dropped: float, chance: Generator
) -> None:
    """Write one recording.

    Args:
        folder: Folder of the recording, which must not exist yet.
        robot: The robot that drove.
        drive: What it drove.
        measuring: How its poses are measured; None for not at all.
        dropped: Share of frames that are lost.
        chance: Source of the poses' noise and of lost frames.
    """
    folder.mkdir(parents=True)
    (folder / "vehicle.toml").write_text(toml_of(robot), encoding="utf-8")
    lines = []
    for sample, time in enumerate(drive.time):
        lines.append(f"({time:.6f}) can0 080#")
        for column, device in enumerate(robot.devices):
            if dropped and chance.random() < dropped:
                continue
            raw = int(drive.counts[sample, column]) % (1 << device.bits)
            data = raw.to_bytes(device.bits // 8, "little").hex().upper()
            lines.append(f"({time + 0.0002 * (column + 1):.6f}) can0 {device.cob_id:03X}#{data}")
    (folder / "can.log").write_text("\n".join(lines) + "\n", encoding="utf-8")
    laps = [
        f'[[lap]]\ndirection = "{name}"\nstart = {start:.6f}\nend = {end:.6f}\n'
        for name, start, end in drive.laps
    ]
    (folder / "run.toml").write_text('protocol = "free"\n' + "".join(laps), encoding="utf-8")
    if measuring is not None:
        (folder / "poses.csv").write_text(_poses(robot, drive, measuring, chance), encoding="utf-8")


def _poses(robot: Robot, drive: Drive, measuring: Measuring, chance: Generator) -> str:
    rows, stated = ["t,body,x,y,theta,sigma_x,sigma_y,sigma_theta"], ",".join(map(str, measuring.sigma))
    for time, truck, pose in measured(robot, drive, measuring, chance):
        heading = (pose[2] + np.pi) % (2.0 * np.pi) - np.pi
        rows.append(f"{time:.6f},{'ab'[truck]},{pose[0]:.6f},{pose[1]:.6f},{heading:.6f},{stated}")
    return "\n".join(rows) + "\n"


def measured(
    robot: Robot, drive: Drive, measuring: Measuring, chance: Generator | None
) -> Iterator[tuple[float, int, Array]]:
    """Yield the stamp [s], the truck's number and the pose `(3,)` of each measurement, in order of time.

    Args:
        robot: The robot that drove.
        drive: What it drove.
        measuring: How its poses are measured.
        chance: Source of the poses' noise; None for none.
    """
    sigma, start = np.array(measuring.sigma), float(drive.time[0])
    if measuring.period == 0.0:
        times = [start + 0.3, *(end for _, _, end in drive.laps)]
    else:
        last = float(drive.time[-1]) - measuring.delay - 2.0 * abs(measuring.fast) * (drive.time[-1] - start)
        times = list(np.arange(start, last, measuring.period))
    for time in times:
        stamp = start + (time - start) / (1.0 - measuring.fast) + measuring.delay
        for truck in range(robot.trucks if measuring.both else 1):
            pose = np.array([np.interp(time, drive.time, drive.poses[:, truck, axis]) for axis in range(3)])
            pose[:2] += _turned(measuring.lever, pose[2])
            if chance is not None:
                off = measuring.noise * sigma * chance.normal(size=3)
                outlier = measuring.outliers and chance.random() < measuring.outliers
                pose += 10.0 * off if outlier else off
            yield stamp, truck, pose


def _turned(lever: tuple[float, float], heading: float) -> tuple[float, float]:
    cosine, sine = np.cos(heading), np.sin(heading)
    return cosine * lever[0] - sine * lever[1], sine * lever[0] + cosine * lever[1]
