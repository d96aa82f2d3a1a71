"""The runner: executes a program, one step per sample, by odometry and the linkage alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.motion.program import ProgramError
from omnimate.motion.records import Settings, State
from omnimate.motion.stepping import step
from omnimate.vehicle.compiled import Record, record

if TYPE_CHECKING:
    from omnimate.motion.program import Program
    from omnimate.vehicle.arcs import PoseTuple
    from omnimate.vehicle.parameters import VehicleParameters


def settings_of(program: Program, vehicle: VehicleParameters) -> Record:
    """Return the settings record `(1,)` with which a vehicle drives a program."""
    settings = record(Settings)
    row = settings[0]
    trucks = list(vehicle.trucks.values())
    row["trucks"], row["parallel"] = len(trucks), program.follower == "parallel"
    row["period"] = vehicle.bus.sync_period
    row["speed"], row["acceleration"] = vehicle.limits.speed, vehicle.limits.acceleration
    wheelbases = np.array(
        [vehicle.trucks["a"].wheelbase, vehicle.trucks["b" if len(trucks) == 2 else "a"].wheelbase]
    )
    row["wheelbase"] = wheelbases
    counts = [abs(vehicle.metres_per_count(wheel)) for wheel in vehicle.wheels]
    for number, wheel in enumerate(vehicle.wheels):
        row["radius"][number] = 0.5 * vehicle.wheel_diameter(wheel)
    row["tolerance"] = max(counts)
    row["turn_tolerance"] = 2.0 * max(counts) / wheelbases
    if vehicle.linkage is not None:
        row["link_length"] = vehicle.linkage.length
        joint = max(abs(vehicle.encoder("joint_a").scale), abs(vehicle.encoder("joint_b").scale))
        reach = joint * vehicle.linkage.length + abs(vehicle.encoder("link").scale)
        row["tolerance"][1] = max(row["tolerance"][1], reach)
        row["turn_tolerance"][1] = max(row["turn_tolerance"][1], 2.0 * joint)
    return settings


class Runner:
    """Drives a program.

    Call `step` once per sample with the pose by odometry. Whenever `fix_due` is true after a
    step, the robot stands, and its odometry may be initialised from an absolute fix before the next one.
    """

    def __init__(self, program: Program, vehicle: VehicleParameters) -> None:
        """Begin a program.

        Raises:
            ProgramError: A row moves a truck that the vehicle does not have.
        """
        for number, row in enumerate(program.rows):
            if row.truck >= len(vehicle.trucks):
                raise ProgramError(
                    number,
                    f"moves truck b; {vehicle.name} has truck a alone: make it with link_length=None",
                )
        self.program = program
        self.rows = program.table
        self.settings = settings_of(program, vehicle)
        self.state = record(State)
        self.state["lap"] = -1
        self._wheels = np.zeros(len(vehicle.wheels))
        self._linked = vehicle.linkage is not None
        self._load()

    def _load(self) -> None:
        """Run a step on a copy of the state, so that code is compiled before the robot moves."""
        step(self.rows, self.settings, self.state.copy(), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), self._wheels)
        self._wheels[:] = 0.0

    def step(self, pose_a: PoseTuple, link: PoseTuple | None = None) -> tuple[float, ...]:
        """Return the wheel speeds [rad/s], in the order of `vehicle.wheels`, until the next sample.

        `pose_a` is x [m], y [m], theta [rad] of truck a by odometry, theta wrapped or not; `link` joint_a
        [rad], joint_b [rad] and length [m] as read, None for a single truck.

        Raises:
            ValueError: two trucks and no link.
        """
        if self._linked and link is None:
            raise ValueError("no reading of the linkage; a robot with two trucks needs it in every step")
        x, y, theta = pose_a
        pose = float(x), float(y), float(theta)  # numba would compile again for integers
        step(self.rows, self.settings, self.state, pose, link or (0.0, 0.0, 0.0), self._wheels)
        return tuple(self._wheels.tolist())

    def halt(self) -> tuple[float, ...]:
        """Return wheel speeds of zero for an unplanned stop; the next step goes on from standstill."""
        self.state["speeds"] = 0.0
        return (0.0,) * len(self._wheels)

    @property
    def done(self) -> bool:
        """Whether the whole program has been driven; the wheels stand."""
        return bool(self.state["row"][0] == len(self.rows))

    @property
    def lap(self) -> int | None:
        """The lap that is being driven, from 0; None between laps."""
        lap = int(self.state["lap"][0])
        return None if lap < 0 else lap

    @property
    def fix_due(self) -> bool:
        """Whether an absolute fix is due now, before the next step."""
        return bool(self.state["fix_due"][0])

    @property
    def at_rest(self) -> bool:
        """Whether all wheels stood since the step before."""
        return bool(self.state["at_rest"][0])

    @property
    def progress(self) -> float:
        """The part of the program's rows that is done, 0 to 1."""
        return min(1.0, float(self.state["row"][0]) / len(self.rows))
