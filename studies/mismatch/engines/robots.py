"""Random robots, and their `vehicle.toml` written straight from the recording's specification."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.random import Generator
    from numpy.typing import NDArray

WHEELS = ("a.left", "a.right", "b.left", "b.right")
LINKAGE = ("joint_a", "joint_b", "link")


@dataclass(frozen=True, slots=True)
class Device:
    """One encoder: where its counts are on the bus, and what a count is.

    Attributes:
        channel: Channel that it measures.
        node: CANopen node id.
        cob_id: COB-ID of its PDO.
        start_bit: First bit of the counts in the PDO.
        bits: Width of the counts.
        signed: Whether the counts are in two's complement.
        sign: +1 or -1, the direction in which it counts.
        resolution: Counts per turn; per metre for the link.
        zero: Counts at angle 0, or at the link's length at rest.
    """

    channel: str
    node: int
    cob_id: int
    start_bit: int
    bits: int
    signed: bool
    sign: int
    resolution: int
    zero: int


@dataclass(frozen=True, slots=True)
class Robot:
    """A robot as its owner believes it to be.

    Attributes:
        name: Name of the robot.
        trucks: Number of trucks, 1 or 2.
        wheelbase: Wheelbase of each truck [m].
        radius: Radius of each wheel [m].
        length: Length of the link at rest [m].
        period: Period of SYNC [s].
        devices: Encoders of the robot.
        jitter: Scatter of the linkage's readings beside their rounding [counts].
        servo: Most acceleration [m/s^2] and turn acceleration [rad/s^2].
        steady: Gain with which truck a, driving backwards, turns into the link [1/m]; else it leaves it.
    """

    name: str
    trucks: int
    wheelbase: tuple[float, ...]
    radius: tuple[float, ...]
    length: float
    period: float
    devices: tuple[Device, ...]
    jitter: float = 0.2
    servo: tuple[float, float] = (0.5, 1.2)
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
