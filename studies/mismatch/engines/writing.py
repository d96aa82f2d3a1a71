"""Random robots, and recording folders written straight from their specification."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from studies.mismatch.engines.strength import Drive as Seen
from studies.mismatch.engines.strength import Poses
from studies.mismatch.engines.vocabulary import LINKAGE, WHEELS, Array

Pose = tuple[float, int, Array]  # stamp [s], number of the truck, x [m], y [m] and heading [rad]

ARRIVAL = 2e-4  # [s] from SYNC to the first frame, and from each frame to the next


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

    @property
    def unit(self) -> float:
        """What `resolution` counts are: a turn [rad], or a metre."""
        return 1.0 if self.channel == "link" else 2.0 * np.pi

    def counted(self, value: Array, scatter: Array | float = 0.0) -> NDArray[np.int64]:
        """Return the counts of readings [rad, m], the link's from its length at rest, and scatter."""
        counts = self.resolution * value / self.unit
        return np.asarray(self.zero + self.sign * np.floor(counts + 0.5 + scatter).astype(np.int64))

    def reading(self, counts: NDArray[np.int64]) -> Array:
        """Return the readings of counts [rad, m]."""
        return np.asarray(self.sign * (counts - self.zero) / self.resolution * self.unit)


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
    sync_scatter: float = 0.0  # standard deviation of the stamps of SYNC on the bus [s]

    @property
    def channels(self) -> tuple[str, ...]:
        """Channels of the encoders, in the order of `devices`."""
        return tuple(device.channel for device in self.devices)


@dataclass(frozen=True, slots=True)
class Log:
    """A drive as it is recorded, sample by sample, and where the robot really was."""

    time: Array  # time of each sample [s], shape `(N,)`
    counts: NDArray[np.int64]  # counts of each device, shape `(N, D)`
    poses: Array  # true pose of each truck: x [m], y [m], heading [rad] that never wraps, shape `(N, T, 3)`
    laps: Sequence[tuple[str, float, float]]  # direction, start [s] and end [s]
    stops: Sequence[float] | None = None  # when poses are measured at rest [s]; None for the ends of the laps
    protocol: str = "free"
    side: float | None = None  # of UMBmark's square [m]


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
    """Return the encoders of a robot on these nodes, with random signs, widths and zeros.

    `resolutions` are counts per turn of the wheels, per turn of the joints, and per metre of the link.
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
        if device.zero and device.channel in LINKAGE:  # a wheel has no zero
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
    folder: Path, robot: Robot, log: Log, measuring: Measuring | None, dropped: float, chance: Generator
) -> None:
    folder.mkdir(parents=True)
    (folder / "vehicle.toml").write_text(toml_of(robot), encoding="utf-8")
    (folder / "can.log").write_text(_frames(robot, log, dropped, chance), encoding="utf-8")
    run = [f'protocol = "{log.protocol}"', *([] if log.side is None else [f"side = {log.side}"])]
    for name, start, end in log.laps:
        run += ["[[lap]]", f'direction = "{name}"', f"start = {start:.6f}", f"end = {end:.6f}"]
    (folder / "run.toml").write_text("\n".join(run) + "\n", encoding="utf-8")
    if measuring is not None:
        (folder / "poses.csv").write_text(_poses(robot, log, measuring, chance), encoding="utf-8")


def _frames(robot: Robot, log: Log, dropped: float, chance: Generator) -> str:
    """Return the text of can.log: SYNC, then a frame of every node."""
    frames: dict[int, list[tuple[int, Device]]] = {}
    for column, device in enumerate(robot.devices):
        frames.setdefault(device.cob_id, []).append((column, device))
    stamps = _stamps(log.time, robot.sync_scatter, len(frames), chance)
    lines = []
    for row, counts in zip(stamps.tolist(), log.counts.tolist(), strict=True):
        lines.append(f"({row[0]:.6f}) can0 080#")
        for time, (cob_id, devices) in zip(row[1:], frames.items(), strict=True):
            if dropped and chance.random() < dropped:
                continue
            word = sum(
                counts[column] % (1 << encoder.bits) << encoder.start_bit for column, encoder in devices
            )
            size = max(encoder.start_bit + encoder.bits for _, encoder in devices) // 8
            lines.append(f"({time:.6f}) can0 {cob_id:03X}#{word.to_bytes(size, 'little').hex().upper()}")
    return "\n".join(lines) + "\n"


def _stamps(time: Array, scatter: float, frames: int, chance: Generator) -> Array:
    """Return the stamps of SYNC and of each frame after it [s], shape `(N, 1 + frames)`."""
    if not scatter:
        return np.asarray(time[:, None] + ARRIVAL * np.arange(1 + frames))
    sync = time + chance.normal(0.0, scatter, len(time)).clip(-4.0 * scatter, 4.0 * scatter)
    late = [1.3e-4 * place + chance.uniform(0.0, scatter, len(time)) for place in range(1, 1 + frames)]
    return np.asarray(sync[:, None] + np.stack([np.zeros(len(time)), *late], axis=1))


def _poses(robot: Robot, log: Log, measuring: Measuring, chance: Generator) -> str:
    rows, stated = ["t,body,x,y,theta,sigma_x,sigma_y,sigma_theta"], ",".join(map(str, measuring.sigma))
    for time, truck, pose in measured(robot, log, measuring, chance):
        heading = (pose[2] + np.pi) % (2.0 * np.pi) - np.pi
        rows.append(f"{time:.6f},{'ab'[truck]},{pose[0]:.6f},{pose[1]:.6f},{heading:.6f},{stated}")
    return "\n".join(rows) + "\n"


def measured(robot: Robot, log: Log, measuring: Measuring | None, chance: Generator | None) -> Iterator[Pose]:
    """Yield each measured pose in order of time; `chance` is the source of noise, None for none."""
    if measuring is None:
        return
    sigma, start, end = np.array(measuring.sigma), float(log.time[0]), float(log.time[-1])
    if measuring.period == 0.0:
        times = [start + 0.3, *(end for _, _, end in log.laps)] if log.stops is None else list(log.stops)
    else:
        last = end - measuring.delay - 2.0 * abs(measuring.fast) * (end - start)
        times = list(np.arange(start, last, measuring.period))
    for time in times:
        stamp = start + (time - start) / (1.0 - measuring.fast) + measuring.delay
        for truck in range(robot.trucks if measuring.both else 1):
            pose = np.array([np.interp(time, log.time, log.poses[:, truck, axis]) for axis in range(3)])
            cosine, sine, (ahead, left) = np.cos(pose[2]), np.sin(pose[2]), measuring.lever
            pose[:2] += cosine * ahead - sine * left, sine * ahead + cosine * left
            if chance is not None:
                off = measuring.noise * sigma * chance.normal(size=3)
                outlier = measuring.outliers and chance.random() < measuring.outliers
                pose += 10.0 * off if outlier else off
            yield stamp, truck, pose


def seen(robot: Robot, log: Log, measuring: Measuring | None, chance: Generator | None) -> Seen:
    """Return a drive as a reader of its recording sees it; `chance` as in `measured`."""
    read = {device.channel: device.reading(log.counts[:, at]) for at, device in enumerate(robot.devices)}
    wheels = np.stack([read[wheel] for wheel in WHEELS[: 2 * robot.trucks]], axis=1)
    if robot.trucks == 1:
        linkage = np.zeros((len(log.time), 0))
    else:
        joints = (np.unwrap(read[joint]) for joint in LINKAGE[:2])
        linkage = np.stack([*joints, robot.length + read["link"]], axis=1)
    return seen_exactly(robot, log.time, wheels, linkage, measured(robot, log, measuring, chance))


def seen_exactly(robot: Robot, time: Array, wheels: Array, linkage: Array, poses: Iterator[Pose]) -> Seen:
    """Return a drive by the readings of its sensors, and poses in order of time.

    Angles of wheels are [rad], `(N, 2 T)`; the linkage is joint_a [rad], joint_b [rad] and the link's length
    [m], shape `(N, 3)`, or `(N, 0)`.
    """
    rows: dict[int, list[tuple[float, Array]]] = {}
    for stamp, truck, pose in poses:
        rows.setdefault(truck, []).append((stamp, pose))
    measurements = {}
    for truck, measured in rows.items():
        pose = np.stack([each for _, each in measured])
        pose[:, 2] = np.unwrap(pose[:, 2])
        measurements[truck] = Poses(np.array([stamp for stamp, _ in measured]), pose)
    radius = np.array(robot.radius)
    turn = np.array([device.resolution for device in robot.devices if device.channel in WHEELS])
    count, base = 2.0 * np.pi * radius / turn, np.array(robot.wheelbase)
    return Seen(time, radius * wheels, count, radius, base, linkage, robot.length, measurements)
