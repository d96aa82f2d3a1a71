"""Recording folders, written from their specification alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.proof.robots import toml_of

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.random import Generator

    from omnimate.proof.engine import Drive
    from omnimate.proof.robots import Robot


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
        outliers: Share of poses that are ten times as far off.
    """

    sigma: tuple[float, float, float]
    period: float
    both: bool
    noise: float = 1.0
    lever: tuple[float, float] = (0.0, 0.0)
    delay: float = 0.0
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
    rows, sigma = ["t,body,x,y,theta,sigma_x,sigma_y,sigma_theta"], np.array(measuring.sigma)
    if measuring.period == 0.0:
        times = [drive.time[0] + 0.3, *(end for _, _, end in drive.laps)]
    else:
        times = list(np.arange(drive.time[0], drive.time[-1] - measuring.delay, measuring.period))
    for time in times:
        for truck in range(robot.trucks if measuring.both else 1):
            true = np.array([np.interp(time, drive.time, drive.poses[:, truck, axis]) for axis in range(3)])
            true[:2] += _turned(measuring.lever, true[2])
            measured = true + measuring.noise * sigma * chance.normal(size=3)
            if measuring.outliers and chance.random() < measuring.outliers:
                measured += 10.0 * (measured - true)
            heading = (measured[2] + np.pi) % (2.0 * np.pi) - np.pi
            place = f"{measured[0]:.6f},{measured[1]:.6f},{heading:.6f}"
            stated = ",".join(str(each) for each in measuring.sigma)
            rows.append(f"{time + measuring.delay:.6f},{'ab'[truck]},{place},{stated}")
    return "\n".join(rows) + "\n"


def _turned(lever: tuple[float, float], heading: float) -> tuple[float, float]:
    cosine, sine = np.cos(heading), np.sin(heading)
    return cosine * lever[0] - sine * lever[1], sine * lever[0] + cosine * lever[1]
