"""A hall's recordings as a store, `robot=NAME/day=DATE/HHMMSS/`, with its truth as `hall.toml`."""

from __future__ import annotations

from dataclasses import asdict
from datetime import UTC, datetime
from typing import TYPE_CHECKING

import tomli_w

from omnimate.files.recordings.folder import save_recording
from omnimate.fleet.hall.hall import DAY, FIRST_DAY, hall_lap
from omnimate.vehicle.atomic import write_text

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from omnimate.fleet.hall.hall import Hall

TRUTH = "hall.toml"


def write_store(
    hall: Hall,
    store: Path,
    days: range,
    laps: int,
    minutes: float,
    *,
    pose_period: float = 0.0,
    compress: bool = True,
    progress: Callable[[int, int], None] = lambda _done, _total: None,
) -> int:
    """Write the recordings of all robots on some days; return how many.

    Args:
        hall: The hall.
        store: Folder of the store; it is made where it is absent.
        days: Days, from 0.
        laps: Laps of each robot on each day.
        minutes: Time of each lap, about [min].
        pose_period: Time between readings of the pose [s]; 0 for docks alone.
        compress: Whether logs are written as `can.log.gz`.
        progress: Called with how many are written, and of how many.

    Raises:
        RecordingError: A recording cannot be written.
    """
    store.mkdir(parents=True, exist_ok=True)
    write_text(store / TRUTH, truth_text(hall))
    total, done = len(days) * len(hall.robots) * laps, 0
    for day in days:
        for robot in hall.robots:
            for lap in range(laps):
                recording = hall_lap(hall, robot, day, lap, minutes, pose_period)
                began = datetime.fromtimestamp(float(recording.time[0]), UTC)
                place = store / f"robot={robot.vehicle.name}" / f"day={began:%Y-%m-%d}"
                save_recording(recording, place / f"{began:%H%M%S}", compress=compress)
                done += 1
                progress(done, total)
    return total


def truth_text(hall: Hall) -> str:
    """Return what is wrong in a hall, as TOML: its bad places, and who turns sick when."""
    places = [asdict(place) for place in hall.places]
    sick = [
        {"robot": robot.vehicle.name, **asdict(ill), "since": date_of(ill.day)}
        for robot in hall.robots
        for ill in robot.ills
    ]
    size = {"length": hall.length, "width": hall.width, "seed": hall.seed}
    return tomli_w.dumps({**size, "docks": hall.docks.tolist(), "place": places, "sick": sick})


def date_of(day: int) -> str:
    """Return the date of a day of the hall, from 0."""
    return f"{datetime.fromtimestamp(FIRST_DAY + day * DAY, UTC):%Y-%m-%d}"
