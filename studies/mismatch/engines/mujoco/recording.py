"""A MuJoCo drive as a recording folder: encoders, frames on the bus, measured poses, laps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from studies.mismatch.engines.vocabulary import WHEELS

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from studies.mismatch.engines.mujoco.control import Program
    from studies.mismatch.engines.true_motion import Drive, Nominal

CHANNELS = (*WHEELS, "joint_a", "joint_b", "link")
# Standard deviations of measured poses [m, m, rad], by kind; exact ones judge what others estimate.
SIGMAS = {"sonar": (0.002, 0.002, 0.0052), "mocap": (0.001, 0.001, 0.00175), "exact": (1e-6, 1e-6, 1e-6)}
GROUPS = (("a.left", "a.right"), ("b.left", "b.right"), ("joint_a", "joint_b"), ("link",))


@dataclass(frozen=True, slots=True)
class Encoder:
    """One encoder on the bus."""

    channel: str  # channel that it measures
    node: int  # CANopen node id
    start_bit: int  # first bit in its PDO
    bits: int  # width of its counter
    sign: int  # +1 or -1, the direction in which it counts
    counts: int  # counts per turn; per metre for the link
    start: int  # raw count at angle 0, or at the link's length at rest
    noise: float  # standard deviation of its reading [rad, m]

    @property
    def per_unit(self) -> float:
        """Counts per radian, or per metre for the link."""
        return self.counts if self.channel == "link" else self.counts / (2 * np.pi)

    def raw(self, value: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.int64]:
        """Return the raw counts of values [rad, m], shape `(N,)`, wrapped at the counter's width."""
        noisy = value + rng.normal(0, self.noise, len(value)) if self.noise else value
        counts = self.start + self.sign * np.floor(noisy * self.per_unit).astype(np.int64)
        return np.asarray(counts % (1 << self.bits))


def random_encoders(rng: np.random.Generator) -> tuple[Encoder, ...]:
    """Return a robot's seven encoders, as four nodes with one PDO each."""
    nodes = rng.choice(np.arange(1, 60), 4, replace=False)
    wheel, joint, link = (
        rng.choice([8192, 20000, 40000]),
        rng.choice([16384, 36000, 65536]),
        rng.choice([10000, 50000]),
    )
    bits = int(rng.choice([24, 32]))
    out = []
    for node, group in zip(nodes, GROUPS, strict=True):
        for place, channel in enumerate(group):
            turning = channel in WHEELS
            counts = int(wheel if turning else link if channel == "link" else joint)
            width = bits if turning else 32
            start = int(rng.integers(-4000, 4000)) if turning or rng.random() < 0.5 else 0
            noise = 0.0 if turning else 5e-5
            sign = int(rng.choice([1, -1]))
            out.append(Encoder(channel, int(node), place * width, width, sign, counts, start, noise))
    return tuple(out)


def readings(drive: Drive, rest: float) -> dict[str, NDArray[np.float64]]:
    """Return what perfect sensors read, by channel [rad, m]; the link counts from its length at rest."""
    table = [*drive.wheels.T, *drive.joints.T, drive.link - rest]
    return dict(zip(CHANNELS, table, strict=True))


def write_recording(
    folder: Path,
    drive: Drive,
    values: dict[str, NDArray[np.float64]],
    nominal: Nominal,
    encoders: tuple[Encoder, ...],
    program: Program,
    poses: str,
    start: float,
    rng: np.random.Generator,
) -> None:
    """Write the files of a recording folder.

    Args:
        folder: Folder of the recording; it is made where it is absent.
        drive: The drive that was recorded.
        values: Readings of each channel [rad, m], shape `(N,)`.
        nominal: The robot as `vehicle.toml` describes it.
        encoders: Encoders on the bus.
        program: What was driven; its laps are written to `run.toml`.
        poses: Kind of absolute poses: none, or one of `SIGMAS`.
        start: Time of the first SYNC [s].
        rng: Source of the noise.
    """
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "vehicle.toml").write_text(_vehicle(nominal, encoders, drive.time[1] - drive.time[0]))
    (folder / "can.log").write_text(_log(drive.time + start, values, encoders, rng))
    (folder / "run.toml").write_text(_run(program, drive.time + start))
    if poses != "none":
        (folder / "poses.csv").write_text(_poses(drive, program, poses, start, rng))


def _vehicle(nominal: Nominal, encoders: tuple[Encoder, ...], period: float) -> str:
    lines = ['name = "contact"']
    for i, truck in enumerate("ab"):
        left, right = 2 * nominal.radii[2 * i : 2 * i + 2]
        lines += [f"\n[truck.{truck}]", f"wheelbase = {nominal.tracks[i]:.6f}"]
        lines += [f"wheel_diameter_left = {left:.7f}", f"wheel_diameter_right = {right:.7f}"]
    lines += ["\n[linkage]", f"length = {nominal.link:.6f}"]
    lines += ["\n[bus]", "bitrate = 500000", f"sync_period = {period:.4f}"]
    for e in encoders:
        lines += [
            "\n[[encoder]]",
            f'channel = "{e.channel}"',
            f"node = {e.node}",
            f"cob_id = {0x180 + e.node:#x}",
        ]
        lines += [f"start_bit = {e.start_bit}", f"bits = {e.bits}", "signed = true", f"sign = {e.sign}"]
        lines += [f"counts_per_{'metre' if e.channel == 'link' else 'turn'} = {e.counts}"]
        lines += [] if e.channel in WHEELS else [f"zero = {e.start}"]
    return "\n".join([*lines, ""])


def _log(
    time: NDArray[np.float64],
    values: dict[str, NDArray[np.float64]],
    encoders: tuple[Encoder, ...],
    rng: np.random.Generator,
) -> str:
    words: dict[int, NDArray[np.object_]] = {}
    bits: dict[int, int] = {}
    for e in encoders:
        shifted = e.raw(values[e.channel], rng).astype(object) * (1 << e.start_bit)
        words[e.node] = words[e.node] + shifted if e.node in words else shifted
        bits[e.node] = max(bits.get(e.node, 0), e.start_bit + e.bits)
    sync = time + rng.normal(0, 5e-5, len(time)).clip(-2e-4, 2e-4)
    blocks = [[f"({t:.6f}) can0 080#" for t in sync]]
    for place, node in enumerate(sorted(words), start=1):
        size = bits[node] // 8
        late = sync + 1.3e-4 * place + rng.uniform(0, 5e-5, len(sync))
        data = (int(word).to_bytes(size, "little").hex().upper() for word in words[node])
        blocks.append(
            [f"({t:.6f}) can0 {0x180 + node:03X}#{word}" for t, word in zip(late, data, strict=True)]
        )
    return "\n".join([*(line for row in zip(*blocks, strict=True) for line in row), ""])


def _run(program: Program, time: NDArray[np.float64]) -> str:
    lines = [f'protocol = "{program.protocol}"']
    lines += [f"side = {program.side}"] if program.side else []
    for direction, first, last in program.laps:
        lines += [
            "\n[[lap]]",
            f'direction = "{direction}"',
            f"start = {time[first]:.3f}",
            f"end = {time[last]:.3f}",
        ]
    return "\n".join([*lines, ""])


def _poses(drive: Drive, program: Program, kind: str, start: float, rng: np.random.Generator) -> str:
    """Return the poses of both trucks: 50 a second, or at the stops before and after the laps."""
    sigma = SIGMAS[kind]
    stops = [program.laps[0][1] - 10, *(last + 20 for _, _, last in program.laps)]
    rows = np.array(stops) if kind == "sonar" else np.arange(0, len(drive.time), 2)
    lines = ["t,body,x,y,theta,sigma_x,sigma_y,sigma_theta"]
    for row in rows:
        for i, body in enumerate("ab"):
            x, y, theta = drive.poses[row, i] + rng.normal(0, sigma)
            theta = np.arctan2(np.sin(theta), np.cos(theta))
            scatter = ",".join(f"{value:g}" for value in sigma)
            lines.append(f"{drive.time[row] + start:.6f},{body},{x:.6f},{y:.6f},{theta:.6f},{scatter}")
    return "\n".join([*lines, ""])
