"""A whole drive as arrays, without a bus, by the same compiled functions that run live."""

from typing import TYPE_CHECKING

import numpy as np

from omnimate.motion.journal import Journal
from omnimate.motion.runner import Runner
from omnimate.motion.stepping import step
from omnimate.vcan_sim.errors import EndStopError, SimulationError
from omnimate.vcan_sim.onboard import odometry_of, see
from omnimate.vcan_sim.plant import Plant
from omnimate.vcan_sim.signal_path import advance
from omnimate.vehicle.compiled import Array, IntArray, Record, compiled
from omnimate.vehicle.parameters import CHANNELS
from omnimate.vehicle.recording import Recording

if TYPE_CHECKING:
    from omnimate.motion.program import Program
    from omnimate.vcan_sim.truth import Truth
    from omnimate.vehicle.parameters import VehicleParameters

BLOCK = 65536  # samples that are simulated at once
LONGEST = 86400.0  # [s] after which a program that does not end is given up


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
    """Fill samples `(N, 7)` and commands `(N, 4)` from `first` on, until something happens; return where."""
    for sample in range(first, len(counts)):
        for channel in range(counts.shape[1]):
            counts[sample, channel] = plants[0].counts[channel]
        pose, link = see(odometries[0], counts[sample])
        happened = step(rows, settings, runner, pose, link, commands[sample])
        advance(constants, plants, obstacles, commands[sample], period)
        if happened or plants[0].end_stop:
            return sample + 1
    return len(counts)


def drive_altered(
    runner: Runner, odometries: Record, plant: Plant, counts: IntArray, commands: Array, first: int
) -> int:
    """Do as `drive_block` does, for a robot with effects."""
    period = plant.vehicle.bus.sync_period
    for sample in range(first, len(counts)):
        counts[sample] = plant.state["counts"][0]
        pose, link = see(odometries[0], counts[sample])
        happened = step(runner.rows, runner.settings, runner.state, pose, link, commands[sample])
        plant.advance(commands[sample], period)
        if happened or plant.at_end_stop:
            return sample + 1
    return len(counts)


class _Drive:
    """A robot and its runner, on their way through a program."""

    def __init__(
        self, vehicle: "VehicleParameters", truth: "Truth", program: "Program", start_time: float
    ) -> None:
        self.vehicle, self.start_time = vehicle, start_time
        self.plant = Plant(truth, vehicle, start_time=start_time)
        self.runner = Runner(program, vehicle)
        self.journal = Journal(program)
        self.odometry = odometry_of(vehicle)
        self.samples = 0

    def block(self, counts: IntArray, commands: Array) -> int:
        """Fill a block of samples and commands; return how many."""
        plant, runner, filled = self.plant, self.runner, 0
        period = self.vehicle.bus.sync_period
        while filled < len(counts) and not runner.done:
            before = filled
            if plant.has_effects:
                filled = drive_altered(runner, self.odometry, plant, counts, commands, filled)
            else:
                filled = drive_block(
                    runner.rows,
                    runner.settings,
                    runner.state,
                    self.odometry,
                    plant.constants,
                    plant.state,
                    plant.obstacles,
                    counts,
                    commands,
                    filled,
                    period,
                )
            self.samples += filled - before
            self._note(self.start_time + (self.samples - 1) * period)
        return filled

    def _note(self, time: float) -> None:
        """Keep the lap, take a fix where one is due, and start odometry from it, U III-C 1)."""
        lap = self.journal.lap
        self.journal.observe(time, self.runner)
        if self.journal.lap != lap:
            self.plant.begin_lap(self.journal.lap)
        if self.plant.at_end_stop:
            raise EndStopError(time - self.start_time, self.plant.link_length)
        if not self.runner.fix_due:
            return
        for truck in self.vehicle.trucks:
            pose, sigma = self.plant.fix(truck)
            self.journal.fix(time, truck, pose, sigma)
            if truck == "a" and np.all(np.isfinite(pose)):
                self.odometry["pose"] = pose


def simulate(
    vehicle: "VehicleParameters", truth: "Truth", program: "Program", *, start_time: float = 0.0
) -> Recording:
    """Return the recording of a robot that drives a program from odometry alone, with fixes at its stops.

    Args:
        vehicle: Robot as its owner believes it to be; its odometry and its file.
        truth: Robot as it truly is.
        program: Program to drive.
        start_time: Time of the first sample [s].

    Raises:
        EndStopError: The linkage was driven to its end stop.
        SimulationError: The program does not end within a day of driving.
    """
    drive = _Drive(vehicle, truth, program, start_time)
    period = vehicle.bus.sync_period
    all_counts, all_commands = [], []
    while not drive.runner.done:
        counts, commands = np.zeros((BLOCK, len(CHANNELS)), np.int64), np.zeros((BLOCK, 4))
        filled = drive.block(counts, commands)
        all_counts.append(counts[:filled])
        all_commands.append(commands[:filled])
        if drive.samples * period > LONGEST:
            raise SimulationError(f"the program {program.protocol} does not end within {LONGEST:.0f} s")
    columns = [CHANNELS.index(channel) for channel in vehicle.channels]
    samples = np.concatenate(all_counts)[:, columns]
    return Recording(
        vehicle=vehicle,
        time=start_time + period * np.arange(len(samples), dtype=np.float64),
        counts=samples,
        present=np.ones(samples.shape, np.bool_),
        poses=drive.journal.poses,
        run=drive.journal.run,
        commands=np.concatenate(all_commands)[:, : len(vehicle.wheels)],
        source=f"simulation of {vehicle.name}",
    )
