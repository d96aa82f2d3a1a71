"""One lap of a robot through the hall: from dock to dock, as a recording.

The robot drives by its odometry, which is set to the measured pose at each dock. A step of the simulation
calls the compiled functions of `omnimate.vcan_sim.simulate`, with those of the hall's places and faults
between them.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.fleet.hall.faults import apply_wheel_faults
from omnimate.fleet.hall.places import creep_on_slopes, lose_travel
from omnimate.motion.journal import Journal
from omnimate.motion.program import GOTO, WORLD, Program, Row, rest
from omnimate.motion.runner import Runner
from omnimate.motion.stepping import step
from omnimate.vcan_sim.errors import EndStopError
from omnimate.vcan_sim.onboard import odometry_of, update_odometry
from omnimate.vcan_sim.plant import Plant
from omnimate.vcan_sim.signal_path import disturb, move, settle, turn_wheels
from omnimate.vehicle.compiled import Array, IntArray, Record, compiled
from omnimate.vehicle.parameters import CHANNELS
from omnimate.vehicle.recording import Poses, Recording
from omnimate.vehicle.se2 import wrap

if TYPE_CHECKING:
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

    truth: "Truth"
    wheels: Record
    docks: Array
    speed: float
    period: float = 0.0
    seed: int = 0


def drive_lap(vehicle: "VehicleParameters", task: LapTask, places: Record, start_time: float) -> Recording:
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
