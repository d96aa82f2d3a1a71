"""What `omnimate track` says: where the robot is, what was corrected, and why."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rich.box import SIMPLE_HEAD
from rich.table import Table

from omnimate.cli.console import err, out

if TYPE_CHECKING:
    from omnimate.ipec.filter.disturbances import Disturbance
    from omnimate.ipec.filter.findings import Findings
    from omnimate.ipec.filter.slow_parameters import SlowParameters
    from omnimate.ipec.linkage_check import FrozenChannel
    from omnimate.ipec.tracker import Row
    from omnimate.vehicle.parameters import TruckName, VehicleParameters
    from omnimate.vehicle.se2 import Array


def row_in_words(row: Row, first: float) -> str:
    """Return a status line: the time and the pose by each method."""
    poses = {"plain": row.plain, "IPEC": row.ipec, "filter": row.filtered}
    words = [f"{name} {_pose(pose)}" for name, pose in poses.items()]
    sure = f"+-{1e3 * math.hypot(*row.sigma[:2]):.0f} mm {math.degrees(row.sigma[2]):.2f} degrees"
    return "   ".join([f"{row.time - first:8.1f} s", *words]) + f" {sure}"


def _pose(pose: Array) -> str:
    x, y, theta = pose.tolist()
    return f"x {x:.3f} m y {y:.3f} m {math.degrees(theta):.2f} degrees"


def disturbance_in_words(disturbance: Disturbance, first: float, vehicle: VehicleParameters) -> str:
    """Say which wheel was disturbed, when, what it lost, and what that would have done to the heading."""
    truck: TruckName = "a" if disturbance.wheel.startswith("a") else "b"
    turn = math.degrees(disturbance.lost / vehicle.trucks[truck].wheelbase)
    lost = f"{disturbance.wheel} lost {1e3 * disturbance.lost:.1f} mm, a bump or a slip"
    return (
        f"{disturbance.start - first:9.2f} s  {lost}: {turn:.2f} degrees of truck {truck}'s heading corrected"
    )


def frozen_in_words(frozen: FrozenChannel, vehicle: VehicleParameters) -> str:
    """Say which channel of the linkage cannot be believed, and what to do."""
    from omnimate.ipec.linkage_check import in_words

    node = vehicle.encoder(frozen.channel).node
    name = f"{frozen.channel} (node {node})"
    if frozen.expected == 0.0:
        return f"{name} is not read: nothing is corrected; check that its node answers SYNC, and its cob_id"
    return f"{name} {in_words(frozen, frozen.start)}; until then believe plain odometry only"


def show_summary(row: Row, slow: SlowParameters, said: Findings, *, to_stdout: bool) -> None:
    """Print the last poses, what the filter has learned of the encoders, and what contradicts it."""
    console = out if to_stdout else err
    table = Table("truck a", "x [m]", "y [m]", "heading [degrees]", box=SIMPLE_HEAD)
    for name, pose in {"plain": row.plain, "IPEC": row.ipec, "filter": row.filtered, "+-": row.sigma}.items():
        x, y, theta = pose.tolist()
        table.add_row(name, f"{x:.4f}", f"{y:.4f}", f"{math.degrees(theta):.3f}")
    console.print(table)
    table = Table("learned", "value", "+-", box=SIMPLE_HEAD)
    for name, value, sigma, unit in _learned(slow):
        table.add_row(name, f"{value:.3f} {unit}", f"{sigma:.3f}")
    console.print(table)
    for sentence in findings_in_words(said):
        console.print(sentence, markup=False, soft_wrap=True)


def findings_in_words(said: Findings) -> list[str]:
    """Say what is probably wrong with vehicle.toml, and what scatters more than the model expects."""
    wrong = [
        f"vehicle.toml is probably wrong (probability {probability:.2f}): {name}; "
        f"its value is above; --out writes it{_doubt(name)}"
        for name, probability in said.suspects
    ]
    wrong += [
        f"the model is contradicted (probability {probability:.2f}): {name} read more than an angle "
        "and a bias; look for play, eccentricity, a late reading"
        for name, probability in said.misread
    ]
    return wrong + [
        f"the model is contradicted: the {name} scatter {factor:.0f} times as much as on an ordinary floor"
        for name, factor in said.scatter
    ]


def _doubt(name: str) -> str:
    """Return what encoders alone cannot tell of a suspect, and what to do."""
    if name.startswith("bias of joint"):
        return "; an axle that is turned in its truck looks the same: only poses of the truck tell them apart"
    if name.startswith("both diameters"):
        return "; if it is the other truck, the scale is wrong: measure a straight of some metres"
    return ""


def _learned(slow: SlowParameters) -> list[tuple[str, float, float, str]]:
    """Return name, value, standard deviation and unit of each slow parameter."""
    wheels = ("a.left", "a.right", "b.left", "b.right")
    sigma = slow.sigma.tolist()
    rows = [
        (f"{wheel} diameter, beside the file", 1e2 * value, 1e2 * sigma[number], "%")
        for number, (wheel, value) in enumerate(zip(wheels, slow.wheel.tolist(), strict=True))
    ]
    rows += [
        (f"{truck} wheelbase, beside the file", 1e2 * value, 1e2 * sigma[4 + number], "%")
        for number, (truck, value) in enumerate(zip("ab", slow.wheelbase.tolist(), strict=True))
    ]
    rows += [
        (f"{truck} sideways creep per acceleration", 1e3 * value, 1e3 * sigma[6 + number], "ms")
        for number, (truck, value) in enumerate(zip("ab", slow.creep.tolist(), strict=True))
    ]
    rows += [
        (f"joint_{truck} bias", math.degrees(value), math.degrees(sigma[8 + number]), "degrees")
        for number, (truck, value) in enumerate(zip("ab", slow.joint_bias.tolist(), strict=True))
    ]
    return [*rows, ("link bias", 1e3 * slow.link_bias, 1e3 * sigma[10], "mm")]
