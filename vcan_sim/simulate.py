"""Simulation of a whole drive without a bus, by the same compiled functions as on a bus."""

from typing import TYPE_CHECKING

import numpy as np

from omnimate.motion.stepping import step
from omnimate.vcan_sim.errors import EndStopError, SimulationError
from omnimate.vcan_sim.onboard import update_odometry
from omnimate.vcan_sim.plant import Plant
from omnimate.vcan_sim.self_driving import SelfDriving
from omnimate.vcan_sim.signal_path import advance
from omnimate.vehicle.compiled import Array, IntArray, Record, compiled
from omnimate.vehicle.parameters import CHANNELS
from omnimate.vehicle.recording import Recording

if TYPE_CHECKING:
    from omnimate.motion.program import Program
    from omnimate.motion.runner import Runner
    from omnimate.vcan_sim.truth import Truth
    from omnimate.vehicle.parameters import VehicleParameters

BLOCK = 65536  # samples of one allocation: 4 MB of counts
MAX_DURATION = 86400.0  # [s] of a drive; a program that does not end within a day is refused


@compiled
def drive_block(
    rows: Record,
    settings: Record,
    runner: Record,
    odometries: Record,
    constants: Record,
    plants: Record,
    obstacles: Record,
    counts: IntArray,
    commands: Array,
    first: int,
    period: float,
) -> int:
    """Fill counts `(N, 7)` and commands `(N, 4)` [rad/s] from row `first` until an event or an end stop.

    Return the number of filled rows.
    """
    for sample in range(first, len(counts)):
        for channel in range(counts.shape[1]):
            counts[sample, channel] = plants[0].counts[channel]
        pose, link = update_odometry(odometries[0], counts[sample])
        has_event = step(rows, settings, runner, pose, link, commands[sample])
        advance(constants, plants, obstacles, commands[sample], period)
        if has_event or plants[0].end_stop:
            return sample + 1
    return len(counts)


def drive_altered(
    runner: "Runner", odometries: Record, plant: Plant, counts: IntArray, commands: Array, first: int
) -> int:
    """Fill counts and commands like `drive_block`, for a robot with effects."""
    period = plant.vehicle.bus.sync_period
    for sample in range(first, len(counts)):
        counts[sample] = plant.state["counts"][0]
        pose, link = update_odometry(odometries[0], counts[sample])
        has_event = step(runner.rows, runner.settings, runner.state, pose, link, commands[sample])
        plant.advance(commands[sample], period)
        if has_event or plant.at_end_stop:
            return sample + 1
    return len(counts)


def fill_block(robot: SelfDriving, plant: Plant, counts: IntArray, commands: Array, first: int) -> int:
    """Fill counts and commands from row `first` until an event or an end stop; return their number."""
    runner, period = robot.runner, plant.vehicle.bus.sync_period
    if plant.has_effects:
        return drive_altered(runner, robot.odometry, plant, counts, commands, first)
    program = runner.rows, runner.settings, runner.state
    records = robot.odometry, plant.constants, plant.state, plant.obstacles
    return drive_block(*program, *records, counts, commands, first, period)


def simulate(
    vehicle: "VehicleParameters", truth: "Truth", program: "Program", *, start_time: float = 0.0
) -> Recording:
    """Return the recording of a robot that drives a program by odometry, with sonar poses at its stops.

    Args:
        vehicle: Nominal robot, for its odometry and the recording.
        truth: True robot.
        program: Program to drive.
        start_time: Time of the first sample [s].

    Raises:
        EndStopError: The linkage was driven to its end stop.
        ProgramError: The program moves truck b, which the vehicle does not have.
        SimulationError: The program does not end within a day of driving.
    """
    plant, period, driven = Plant(truth, vehicle, start_time=start_time), vehicle.bus.sync_period, 0
    robot = SelfDriving(vehicle, plant, program)
    all_counts, all_commands = [], []
    while not robot.runner.done:
        counts, commands, filled = np.zeros((BLOCK, len(CHANNELS)), np.int64), np.zeros((BLOCK, 4)), 0
        while filled < BLOCK and not robot.runner.done:
            before, filled = filled, fill_block(robot, plant, counts, commands, filled)
            driven += filled - before
            robot.update(start_time + (driven - 1) * period)
            if plant.at_end_stop:
                raise EndStopError((driven - 1) * period, plant.link_length)
        all_counts.append(counts[:filled])
        all_commands.append(commands[:filled])
        if driven * period > MAX_DURATION:
            raise SimulationError(f"the program {program.protocol} does not end within {MAX_DURATION:.0f} s")
    columns = [CHANNELS.index(channel) for channel in vehicle.channels]
    samples = np.concatenate(all_counts)[:, columns]
    return Recording(
        vehicle=vehicle,
        time=start_time + period * np.arange(len(samples), dtype=np.float64),
        counts=samples,
        present=np.ones(samples.shape, np.bool_),
        poses=robot.journal.poses,
        run=robot.journal.run,
        commands=np.concatenate(all_commands)[:, : len(vehicle.wheels)],
        source=f"simulation of {vehicle.name}",
    )
