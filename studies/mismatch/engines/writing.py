"""Random robots, and recording folders written straight from their specification."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from studies.mismatch.engines.vocabulary import LINKAGE, WHEELS

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from numpy.random import Generator
    from numpy.typing import NDArray

    from studies.mismatch.engines.engine import Drive

    Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Device:
    """One encoder: where its counts are on the bus, and what a count is."""

    channel: str  # channel that it measures
    node: int  # CANopen node id
    cob_id: int  # COB-ID of its PDO
    start_bit: int  # first bit of the counts in the PDO
    bits: int  # width of the counts
    signed: bool  # whether the counts are in two's complement
    sign: int  # +1 or -1, the direction in which it counts
    resolution: int  # counts per turn; per metre for the link
    zero: int  # counts at angle 0, or at the link's length at rest


@dataclass(frozen=True, slots=True)
class Robot:
    """A robot as its owner believes it to be."""

    name: str  # name of the robot
    trucks: int  # number of trucks, 1 or 2
    wheelbase: tuple[float, ...]  # wheelbase of each truck [m]
    radius: tuple[float, ...]  # radius of each wheel [m]
    length: float  # length of the link at rest [m]
    period: float  # period of SYNC [s]
    devices: tuple[Device, ...]  # encoders of the robot
    jitter: float = 0.2  # scatter of the linkage's readings beside their rounding [counts]
    servo: tuple[float, float] = (0.5, 1.2)  # most acceleration [m/s^2] and turn acceleration [rad/s^2]
    # gain with which truck a, driving backwards, turns into the link [1/m]; else it leaves it
    steady: float = 0.0

    @property
    def channels(self) -> tuple[str, ...]:
        """Channels of the encoders, in the order of `devices`."""
        return tuple(device.channel for device in self.devices)


def random_robot(chance: Generator, trucks: int) -> Robot:
    """Return a robot of usual size with a bus of random node ids and resolutions."""
    base = float(chance.uniform(0.28, 0.45))
    radius = float(chance.choice([0.06, 0.075, 0.09]))
    nodes = chance.permutation(np.arange(2, 60))
    turn = int(chance.choice([4096, 16384, 20000, 40000]))
    joint = int(chance.choice([4096, 16384, 36000]))
    metre = int(chance.choice([10000, 20000, 50000]))
    devices = encoders(chance, nodes, trucks, (turn, joint, metre))
    return Robot(
        f"proof-{int(chance.integers(1000)):03d}",
        trucks,
        (base,) * trucks,
        (radius,) * (2 * trucks),
        float(chance.uniform(0.8, 1.3)),
        float(chance.choice([0.01, 0.015, 0.02])),
        devices,
    )


def encoders(
    chance: Generator, nodes: NDArray[np.int64], trucks: int, resolutions: tuple[int, int, int]
) -> tuple[Device, ...]:
    """Return the encoders of a robot, with random signs, widths and zeros.

    Args:
        chance: Source of what is drawn.
        nodes: A node id for each, in order.
        trucks: Number of trucks.
        resolutions: Counts per turn of the wheels, per turn of the joints, and per metre of the link.
    """
    turn, joint, metre = resolutions
    devices = []
    for number, channel in enumerate((*WHEELS[: 2 * trucks], *(LINKAGE if trucks == 2 else ()))):
        resolution = turn if channel in WHEELS else metre if channel == "link" else joint
        bits = int(chance.choice([24, 32])) if channel in WHEELS else 32
        zero = 0 if channel in WHEELS else int(chance.integers(0, 2000))
        node = int(nodes[number])
        sign = int(chance.choice([1, -1]))
        signed = bool(chance.integers(2)) or channel not in WHEELS
        devices.append(Device(channel, node, 0x180 + node, 0, bits, signed, sign, resolution, zero))
    return tuple(devices)


def toml_of(robot: Robot) -> str:
    """Return the text of a robot's vehicle.toml."""
    lines = [f'name = "{robot.name}"']
    for number in range(robot.trucks):
        left, right = robot.radius[2 * number : 2 * number + 2]
        lines += [f"[truck.{'ab'[number]}]", f"wheelbase = {robot.wheelbase[number]!r}"]
        lines += [f"wheel_diameter_left = {2.0 * left!r}", f"wheel_diameter_right = {2.0 * right!r}"]
    if robot.trucks == 2:
        lines += ["[linkage]", f"length = {robot.length!r}"]
    lines += ["[bus]", "bitrate = 500000", f"sync_period = {robot.period!r}"]
    for device in robot.devices:
        kind = "counts_per_metre" if device.channel == "link" else "counts_per_turn"
        lines += [
            "[[encoder]]",
            f'channel = "{device.channel}"',
            f"node = {device.node}",
            f"cob_id = {device.cob_id}",
            f"start_bit = {device.start_bit}",
            f"bits = {device.bits}",
            f"signed = {str(device.signed).lower()}",
            f"sign = {device.sign}",
            f"{kind} = {device.resolution}",
        ]
        if device.zero:
            lines.append(f"zero = {device.zero}")
    return "\n".join(lines) + "\n"


@dataclass(frozen=True, slots=True)
class Measuring:
    """How poses are measured from outside."""

    sigma: tuple[float, float, float]  # standard deviations that are stated: x, y [m] and heading [rad]
    period: float  # time between two poses [s]; 0 for poses at the stops alone
    both: bool  # whether every truck is measured, or truck a alone
    noise: float = 1.0  # factor by which they scatter more than they state
    # place of the markers on the truck, which is believed to be its centre: forward and left [m]
    lever: tuple[float, float] = (0.0, 0.0)
    delay: float = 0.0  # time by which the stamps are late [s]
    fast: float = 0.0  # rate by which the clock of the stamps runs fast
    outliers: float = 0.0  # share of poses that are ten times as far off


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
