"""What `omnimate import` says of recordings and bags."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rich.progress import track

from cli.console import err, out

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from vehicle.parameters import VehicleParameters
    from vehicle.recording import Recording


def show_topics(source: Path, vehicle: VehicleParameters | None) -> None:
    """Say what is in a bag, and what the names in it suggest."""
    from imports.rosbag_guess import as_toml, guess
    from imports.rosbag_reader import topics_of

    topics = topics_of(source)
    for topic in topics:
        parts = f" ({', '.join(topic.parts)})" if topic.parts else ""
        out.print(f"{topic.count:8d}  {topic.kind:32s}  {topic.name}{parts}", soft_wrap=True)
    plan = guess(topics) if vehicle is None else guess(topics, vehicle.channels)
    out.print(
        "\n# a mapping by guess:\n" + (as_toml(plan) or "# nothing is named like a wheel"), soft_wrap=True
    )


def save_set(recordings: Iterable[tuple[str, Recording]], to: Path) -> None:
    """Write many recordings, and say how far the odometry of all of them is off."""
    from imports.sanity import look
    from vehicle.folder import save_recording

    samples, looks = [], []
    for name, recording in track(recordings, "importing", console=err, transient=True):
        (to / name).parent.mkdir(parents=True, exist_ok=True)
        save_recording(recording, to / name)
        samples.append(len(recording))
        looks.append(look(recording))
    out.print(f"{len(samples)} recording(s), {sum(samples)} samples in {to}", soft_wrap=True)
    known = [one for one in looks if one is not None]
    if known:
        away = math.sqrt(sum(one.away**2 for one in known) / len(known))
        turned = math.sqrt(sum(one.turned**2 for one in known) / len(known))
        out.print(
            f"nominal odometry ends {1e3 * away:.1f} mm and {math.degrees(turned):.2f} deg from the last "
            f"pose (root mean square), after {sum(one.way for one in known) / len(known):.2f} m on average",
            soft_wrap=True,
        )


def tell(recording: Recording, to: Path) -> None:
    """Say what a recording holds, and how far its odometry is off."""
    from imports.sanity import look

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
