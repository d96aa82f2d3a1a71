"""Sentences and tables of `omnimate track`: pose, corrections and their reasons."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from omnimate.cli.console import err, out
from omnimate.cli.tables import new_table, pose_cells

if TYPE_CHECKING:
    from omnimate.calib.linkage.learned import LearnedValue
    from omnimate.ipec.filter.findings import Disturbance
    from omnimate.ipec.linkage_check import FrozenChannel
    from omnimate.ipec.tracker import Learned, Row
    from omnimate.vehicle.parameters import TruckName, VehicleParameters
    from omnimate.vehicle.se2 import Array


def row_in_words(row: Row, first: float) -> str:
    """Return a status line: the time and the pose by each method."""
    words = [f"{name} {_pose(pose)}" for name, pose in _poses(row).items()]
    sure = f"+-{1e3 * math.hypot(*row.sigma[:2]):.0f} mm {math.degrees(row.sigma[2]):.2f} degrees"
    return "   ".join([f"{row.time - first:8.1f} s", *words]) + f" {sure}"


def _poses(row: Row) -> dict[str, Array]:
    """Return the pose of truck a by each method; a single truck has no IPEC."""
    poses = {"plain": row.plain, "IPEC": row.ipec, "filter": row.filtered}
    return {name: pose for name, pose in poses.items() if all(map(math.isfinite, pose.tolist()))}


def _pose(pose: Array) -> str:
    x, y, theta = pose.tolist()
    return f"x {x:.3f} m y {y:.3f} m {math.degrees(theta):.2f} degrees"


def disturbance_in_words(disturbance: Disturbance, first: float, vehicle: VehicleParameters) -> str:
    """Return which wheel was disturbed, when, the travel that it lost, and the heading error avoided."""
    truck: TruckName = "a" if disturbance.wheel.startswith("a") else "b"
    turn = math.degrees(disturbance.lost / vehicle.trucks[truck].wheelbase)
    lost = f"{disturbance.wheel} lost {1e3 * disturbance.lost:.1f} mm, a bump or a slip"
    return (
        f"{disturbance.start - first:9.2f} s  {lost}: {turn:.2f} degrees of truck {truck}'s heading corrected"
    )


def frozen_in_words(frozen: FrozenChannel, vehicle: VehicleParameters) -> str:
    """Return a warning that names a frozen channel of the linkage and what to do."""
    from omnimate.ipec.linkage_check import describe_frozen_channel

    node = vehicle.encoder(frozen.channel).node
    name = f"{frozen.channel} (node {node})"
    if frozen.expected == 0.0:
        return f"{name} is not read: nothing is corrected; check that its node answers SYNC, and its cob_id"
    return f"{name} {describe_frozen_channel(frozen, frozen.start)}; until then rely on plain odometry only"


def show_summary(row: Row, learned: Learned | None, *, to_stdout: bool) -> None:
    """Print the last poses, and of two trucks what was learned, contradicted, and not identified yet."""
    from omnimate.calib.linkage.learned import advice_of, learned_values

    console = out if to_stdout else err
    table = new_table("", ("truck a", "x [m]", "y [m]", "heading [degrees]"))
    for name, pose in {**_poses(row), "+-": row.sigma}.items():
        table.add_row(name, *pose_cells(pose))
    console.print(table)
    if learned is None:
        return
    vehicle, slow, findings = learned
    values = learned_values(vehicle, slow)
    console.print(new_table("", ("learned", "value", "+-"), rows=map(_learned, values)))
    for advice in advice_of(findings):
        console.print(str(advice), soft_wrap=True)


def _learned(learned: LearnedValue) -> tuple[str, str, str]:
    """Return name, value with its unit, and standard deviation; sizes relative to those of the file."""
    if learned.described:
        off, sigma = learned.value / learned.described - 1.0, learned.sigma / learned.described
        return f"{learned.name}, relative to file", f"{1e2 * off:.3f} %", f"{1e2 * sigma:.3f}"
    factor, unit = {"m": (1e3, "mm"), "s": (1e3, "ms"), "rad": (math.degrees(1.0), "degrees")}[learned.unit]
    return learned.name, f"{factor * learned.value:.3f} {unit}", f"{factor * learned.sigma:.3f}"
