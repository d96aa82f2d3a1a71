"""The hall: its floor, docks and robots, all random from one seed; its laps, and their store.

In a lap a robot drives from dock to dock by its odometry, which is set to the measured pose at each dock. A
step of the simulation calls the compiled functions of `omnimate.vcan_sim.simulate`, with those of the hall's
places and faults between them.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from typing import TYPE_CHECKING

import numpy as np
import tomli_w

from omnimate.files.recordings.folder import save_recording
from omnimate.fleet.hall.faults import apply_wheel_faults, draw_fault
from omnimate.fleet.hall.places import creep_on_slopes, draw_places, lose_travel, place_records
from omnimate.fleet.hall.robots import TYPES, HallRobot, draw_robot
from omnimate.motion.journal import Journal
from omnimate.motion.program import GOTO, WORLD, Program, Row, rest
from omnimate.motion.runner import Runner
from omnimate.motion.stepping import step
from omnimate.vcan_sim.errors import EndStopError, SimulationError
from omnimate.vcan_sim.onboard import odometry_of, update_odometry
from omnimate.vcan_sim.plant import Plant
from omnimate.vcan_sim.signal_path import disturb, move, settle, turn_wheels
from omnimate.vehicle.atomic import write_text
from omnimate.vehicle.compiled import Array, IntArray, Record, compiled
from omnimate.vehicle.errors import RecordingError
from omnimate.vehicle.parameters import CHANNELS
from omnimate.vehicle.recording import Poses, Recording
from omnimate.vehicle.se2 import wrap

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from omnimate.fleet.hall.places import Place
    from omnimate.vcan_sim.truth import Truth
    from omnimate.vehicle.parameters import VehicleParameters

DOCK_SIGMA = np.array([0.002, 0.002, 0.001])  # [m, m, rad] of a measured pose (assumption)
_START_SIGMA = np.array([0.02, 0.02, 0.01])  # [m, m, rad] of the true pose at the first dock (assumption)
_REST = 1.0  # [s] at a dock
_BLOCK = 8192  # samples by which the arrays grow


@dataclass(frozen=True, slots=True)
class LapTask:
    """The task of a robot in one lap.

    True parameters and wheel faults, a record `(1,)`, are those of that day. The robot visits docks, x [m], y
    [m] and heading [rad], `(M, 3)`, from the first on, at a speed [m/s]. Poses are measured with a period
    [s], 0 for docks only, and with random errors.
    """

    truth: Truth
    wheels: Record
    docks: Array
    speed: float
    period: float = 0.0
    seed: int = 0


def drive_lap(vehicle: VehicleParameters, task: LapTask, places: Record, start_time: float) -> Recording:
    """Return the recording of one lap.

    The places are records from `place_records`; the first sample is at `start_time` [s].

    Raises:
        EndStopError: The linkage was driven to its end stop.
    """
    chance = np.random.default_rng(task.seed)
    start = task.docks[0] + chance.normal(size=3) * _START_SIGMA
    plant = Plant(task.truth, vehicle, (float(start[0]), float(start[1]), float(start[2])))
    program = _program(task)
    runner, journal, odometry = Runner(program, vehicle), Journal(program), odometry_of(vehicle)
    wheels, sides = task.wheels.copy(), np.zeros((len(places), 4))
    period, filled = vehicle.bus.sync_period, 0
    counts, poses = np.zeros((_BLOCK, len(CHANNELS)), np.int64), np.zeros((_BLOCK, 3))
    records = (
        *(runner.rows, runner.settings, runner.state, odometry),
        *(plant.constants, plant.state, plant.obstacles),
    )
    while not runner.done:
        if filled == len(counts):
            counts = np.concatenate([counts, np.zeros_like(counts)])
            poses = np.concatenate([poses, np.zeros_like(poses)])
        filled = hall_block(*records, wheels, places, sides, counts, poses, filled, period)
        if plant.at_end_stop:
            raise EndStopError(filled * period, plant.link_length)
        if runner.fix_due:
            measured = plant.pose("a") + chance.normal(size=3) * DOCK_SIGMA
            measured[2] = wrap(measured[2])
            journal.fix(start_time + (filled - 1) * period, "a", measured, DOCK_SIGMA)
            odometry["pose"] = measured
    time = start_time + period * np.arange(filled, dtype=np.float64)
    columns = [CHANNELS.index(channel) for channel in vehicle.channels]
    dense = _measure_poses(time, poses[:filled], task.period, chance)
    return Recording(
        vehicle=vehicle,
        time=time,
        counts=counts[:filled, columns],
        present=np.ones((filled, len(columns)), np.bool_),
        poses=journal.poses if dense is None else dense,
        run=journal.run,
        source=f"lap of {vehicle.name}",
    )


@compiled
def hall_block(
    rows: Record,
    settings: Record,
    runner: Record,
    odometries: Record,
    constants_: Record,
    plants: Record,
    obstacles: Record,
    all_wheels: Record,
    places: Record,
    sides: Array,
    counts: IntArray,
    poses: Array,
    first: int,
    period: float,
) -> int:
    """Fill counts `(N, 7)` and true poses of truck a `(N, 3)` from row `first` until an event or an end stop.

    Return the number of filled rows.
    """
    constants, state, wheels = constants_[0], plants[0], all_wheels[0]
    command = np.zeros(4)
    for sample in range(first, len(counts)):
        for channel in range(counts.shape[1]):
            counts[sample, channel] = state.counts[channel]
        for axis in range(3):
            poses[sample, axis] = state.pose[0, axis]
        pose, link = update_odometry(odometries[0], counts[sample])
        is_event = step(rows, settings, runner, pose, link, command)
        turn_wheels(constants, state, command, period)
        apply_wheel_faults(wheels, constants, state)
        disturb(constants, state, obstacles)
        lose_travel(places, sides, constants, state)
        move(constants, state)
        creep_on_slopes(places, constants, state)
        settle(constants, state)
        if is_event or state.end_stop:
            return sample + 1
    return len(counts)


def _program(task: LapTask) -> Program:
    """Return the program of a lap: straight to each dock, and a rest with a pose measurement there."""
    rows = [rest(_REST, fix=True)]
    for x, y, heading in task.docks[1:].tolist():
        rows.append(Row(GOTO, x=x, y=y, heading=heading, speed=task.speed, frame=WORLD))
        rows.append(rest(_REST, fix=True))
    return Program("free", tuple(rows), ())


def _measure_poses(time: Array, true: Array, period: float, chance: np.random.Generator) -> Poses | None:
    """Return measured poses with a period [s] from true poses `(N, 3)` at `time`; None for a period of 0."""
    if not period:
        return None
    rows = np.arange(0, len(time), max(1, round(period / float(time[1] - time[0]))))
    measured = true[rows] + chance.normal(size=(len(rows), 3)) * DOCK_SIGMA
    measured[:, 2] = wrap(measured[:, 2])
    return Poses(time[rows], np.full(len(rows), "a"), measured, np.tile(DOCK_SIGMA, (len(rows), 1)))


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
