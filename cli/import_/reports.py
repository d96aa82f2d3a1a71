"""What `omnimate import` says of recordings and bags."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from omnimate.cli.console import out

if TYPE_CHECKING:
    from pathlib import Path

    from omnimate.vehicle.parameters import VehicleParameters
    from omnimate.vehicle.recording import Recording


def show_topics(source: Path, vehicle: VehicleParameters | None) -> None:
    """Say what is in a bag, and what the names in it suggest."""
    from omnimate.files.importers.rosbag.guess import as_toml, guess
    from omnimate.files.importers.rosbag.reader import topics_of

    topics = topics_of(source)
    for topic in topics:
        parts = f" ({', '.join(topic.parts)})" if topic.parts else ""
        out.print(f"{topic.count:8d}  {topic.kind:32s}  {topic.name}{parts}", soft_wrap=True)
    plan = guess(topics) if vehicle is None else guess(topics, vehicle.channels)
    out.print(
        "\n# a mapping by guess:\n" + (as_toml(plan) or "# nothing is named like a wheel"), soft_wrap=True
    )


def report_recording(recording: Recording, to: Path) -> None:
    """Say what a recording holds, and how far its odometry is off."""
    from omnimate.files.importers.sanity import look

    span, period = recording.time[-1] - recording.time[0], recording.vehicle.bus.sync_period
    poses = 0 if recording.poses is None else len(recording.poses.time)
    out.print(
        f"{len(recording)} samples of {span:.1f} s, one in {1e3 * period:.1f} ms, "
        f"{len(recording.gaps)} gap(s), {poses} poses in {to}",
        soft_wrap=True,
    )
    for truck in recording.vehicle.trucks:
        seen = look(recording, truck)
        if seen is not None:
            out.print(
                f"truck {truck}: nominal odometry ends {1e3 * seen.away:.1f} mm and "
                f"{math.degrees(seen.turned):.2f} deg from the last pose, after {seen.way:.2f} m",
                soft_wrap=True,
            )
