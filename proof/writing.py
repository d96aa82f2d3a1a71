"""Recording folders, written from their specification alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.proof.robots import toml_of

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.random import Generator

    from omnimate.proof.engine import Drive
    from omnimate.proof.robots import Robot

SONAR = (0.002, 0.002, 0.004)  # stated sigma of x, y [m] and heading [rad]
MOCAP = (0.001, 0.001, 0.0015)  # likewise
MOCAP_PERIOD = 0.05  # [s] between two poses


def write(
    folder: Path, robot: Robot, drive: Drive, poses: str, noise: float, dropped: float, chance: Generator
) -> None:
    """Write one recording.

    Args:
        folder: Folder of the recording, which must not exist yet.
        robot: The robot that drove.
        drive: What it drove.
        poses: Kind of absolute poses: "none", "sonar" or "mocap".
        noise: Factor by which the poses scatter more than they state.
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
    if poses != "none":
        (folder / "poses.csv").write_text(_poses(robot, drive, poses, noise, chance), encoding="utf-8")


def _poses(robot: Robot, drive: Drive, kind: str, noise: float, chance: Generator) -> str:
    rows = ["t,body,x,y,theta,sigma_x,sigma_y,sigma_theta"]
    sigma = np.array(SONAR if kind == "sonar" else MOCAP)
    if kind == "sonar":
        times = [drive.time[0] + 0.3, *(end for _, _, end in drive.laps)]
        trucks = [0]
    else:
        times = list(np.arange(drive.time[0], drive.time[-1], MOCAP_PERIOD))
        trucks = list(range(robot.trucks))
    for time in times:
        for truck in trucks:
            true = np.array([np.interp(time, drive.time, drive.poses[:, truck, axis]) for axis in range(3)])
            measured = true + noise * sigma * chance.normal(size=3)
            heading = (measured[2] + np.pi) % (2.0 * np.pi) - np.pi
            rows.append(
                f"{time:.6f},{'ab'[truck]},{measured[0]:.6f},{measured[1]:.6f},{heading:.6f},{sigma[0]},{sigma[1]},{sigma[2]}"
            )
    return "\n".join(rows) + "\n"
