"""The hall: its floor, docks and robots, all random from one seed; its laps, and their store."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from typing import TYPE_CHECKING

import numpy as np
import tomli_w

from omnimate.files.recordings.folder import save_recording
from omnimate.fleet.hall.faults import draw_fault
from omnimate.fleet.hall.lap import LapTask, drive_lap
from omnimate.fleet.hall.places import draw_places, place_records
from omnimate.fleet.hall.robots import TYPES, HallRobot, draw_robot
from omnimate.vcan_sim.errors import SimulationError
from omnimate.vehicle.atomic import write_text
from omnimate.vehicle.errors import RecordingError

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from omnimate.fleet.hall.places import Place
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array

TRUTH_FILE = "hall.toml"
DAY = 86400.0  # [s]
FIRST_DAY = 1_772_409_600.0  # [s] 2026-03-02 00:00 UTC, a Monday
_FIRST_LAP = 6.0 * 3600.0  # [s] after midnight, when the first lap begins
_MARGIN = 1.5  # [m] distance of docks and places from the walls (assumption)
_STOP = 8.0  # [s] of a stop at a dock with two turns on the spot, to estimate the time of a lap


@dataclass(frozen=True, slots=True)
class Hall:
    """A hall with its robots.

    Docks are poses x [m], y [m] and heading [rad], `(M, 3)`; the length is along x, the width along y [m].
    """

    length: float
    width: float
    docks: Array
    places: tuple[Place, ...]
    robots: tuple[HallRobot, ...]
    seed: int


def draw_hall(
    robots: int,
    days: int,
    *,
    faulty: int,
    places: int,
    docks: int = 60,
    length: float = 40.0,
    width: float = 30.0,
    sync_period: float = 0.015,
    seed: int = 0,
) -> Hall:
    """Return a random hall.

    Its robots are of three types in turn, and its places of three kinds. Faults begin after a fifth of the
    days, and five days before their end, each suddenly or gradually with equal probability. Length, along x,
    and width are in m, the period of SYNC on each robot's bus in s.

    Raises:
        SimulationError: More robots become faulty than there are, or the bad places do not fit in.
    """
    if faulty > robots:
        raise SimulationError(f"{faulty} faulty robots of {robots}; expected at most as many as there are")
    chance = np.random.default_rng(seed)
    inside = np.array([length, width]) - 2.0 * _MARGIN
    positions = _MARGIN + inside * chance.uniform(size=(docks, 2))
    headings = chance.uniform(-math.pi, math.pi, docks)
    bad = draw_places(places, _MARGIN, inside, chance)
    chosen = set(chance.permutation(robots)[:faulty].tolist())
    fleet = [
        draw_robot(
            TYPES[number % 3],
            number,
            seed,
            sync_period,
            (draw_fault(TYPES[number % 3], days, chance),) if number in chosen else (),
        )
        for number in range(robots)
    ]
    return Hall(length, width, np.column_stack([positions, headings]), bad, tuple(fleet), seed)


def hall_lap(
    hall: Hall, robot: HallRobot, day: int, lap: int, minutes: float, pose_period: float = 0.0
) -> Recording:
    """Return the recording of a lap of a robot on a day; the same arguments give the same recording.

    Days and laps are counted from 0. The lap takes about so many minutes; `pose_period` is the time between
    measured poses [s], 0 for poses at docks only.

    Raises:
        EndStopError: The linkage was driven to its end stop.
    """
    chance = np.random.default_rng((hall.seed, robot.seed, day, lap))
    truth, wheels = robot.truth_on(day, lap)
    speed = 0.9 * robot.vehicle.limits.speed
    visits, time = [int(chance.integers(len(hall.docks)))], 0.0
    while time < 60.0 * minutes:
        other = int(chance.integers(len(hall.docks) - 1))  # any dock but the last one
        visits.append(other + (other >= visits[-1]))
        drive = hall.docks[visits[-1], :2] - hall.docks[visits[-2], :2]
        time += float(np.hypot(*drive)) / speed + _STOP
    task = LapTask(truth, wheels, hall.docks[visits], speed, pose_period, int(chance.integers(2**31)))
    start = FIRST_DAY + day * DAY + _FIRST_LAP + lap * 60.0 * (minutes + 2.0)
    return drive_lap(robot.vehicle, task, place_records(hall.places), start)


def write_store(
    hall: Hall,
    store: Path,
    days: range,
    laps: int,
    minutes: float,
    *,
    pose_period: float = 0.0,
    progress: Callable[[int, int], None] = lambda _done, _total: None,
) -> int:
    """Write the recordings of all robots on some days, and `hall.toml`; return the number of recordings.

    Days are counted from 0. A lap takes about so many minutes; `pose_period` is the time between measured
    poses [s], 0 for poses at docks only. `progress` is called with (recordings written, number of
    recordings).

    Raises:
        RecordingError: The store holds a hall, or a recording cannot be written.
    """
    if (store / TRUTH_FILE).exists():
        raise RecordingError(store, f"it holds a simulated hall ({TRUTH_FILE}); choose another folder")
    store.mkdir(parents=True, exist_ok=True)
    write_text(store / TRUTH_FILE, truth_text(hall))
    total, done = len(days) * len(hall.robots) * laps, 0
    for day in days:
        for robot in hall.robots:
            for lap in range(laps):
                recording = hall_lap(hall, robot, day, lap, minutes, pose_period)
                began = datetime.fromtimestamp(float(recording.time[0]), UTC)
                folder = store / f"robot={robot.vehicle.name}" / f"day={began:%Y-%m-%d}"
                save_recording(recording, folder / f"{began:%H%M%S}", compress=True)
                done += 1
                progress(done, total)
    return total


def truth_text(hall: Hall) -> str:
    """Return the truth of a hall as TOML: its bad places, and the faults of its robots."""
    places = [asdict(place) for place in hall.places]
    faults = [
        {"robot": robot.vehicle.name, **asdict(fault), "since": date_of(fault.day)}
        for robot in hall.robots
        for fault in robot.faults
    ]
    size = {"length": hall.length, "width": hall.width, "seed": hall.seed}
    return tomli_w.dumps({**size, "docks": hall.docks.tolist(), "place": places, "sick": faults})


def date_of(day: int) -> str:
    """Return the date, YYYY-MM-DD, of a day's number, from 0."""
    return f"{datetime.fromtimestamp(FIRST_DAY + day * DAY, UTC):%Y-%m-%d}"
