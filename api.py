"""The public interface: load a recording, calibrate, diagnose, simulate, track, and open a driver.

Every function takes and returns the same types as the rooms behind it, so that a program can begin here and
go on with a room's own functions where it needs more. Units are SI: metres, radians, seconds. All errors that
a caller can solve are `OmnimateError`s, whose message says what was expected, where, and what to do.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING

from omnimate.calib.apply import corrected_vehicle
from omnimate.calib.errors import CalibrationError
from omnimate.calib.paths.least_squares import PathCalibration, calibrate_truck
from omnimate.driver.canopen.dcf import load_descriptions
from omnimate.driver.robot.driver import Driver
from omnimate.driver.robot.driver import open_driver as open_configured
from omnimate.files.recordings.folder import read_recording, save_recording
from omnimate.ipec.filter.estimate import Estimate
from omnimate.ipec.filter.estimate import estimate as track
from omnimate.mismatch import Diagnosis, diagnose
from omnimate.motion.paths import umbmark
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate as simulate_program
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.errors import OmnimateError, VehicleFileError
from omnimate.vehicle.file import load_vehicle
from omnimate.vehicle.file import save_vehicle as write_vehicle
from omnimate.vehicle.parameters import VehicleParameters
from omnimate.vehicle.recording import Recording

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from omnimate.effects.effect import Effect
    from omnimate.motion.program import Program
    from omnimate.vehicle.parameters import TruckName

__all__ = [
    "Calibrated",
    "Diagnosis",
    "Driver",
    "Estimate",
    "OmnimateError",
    "Recording",
    "VehicleParameters",
    "calibrate",
    "diagnose",
    "load_recording",
    "load_vehicle",
    "open_driver",
    "save_recording",
    "save_vehicle",
    "simulate",
    "track",
]


MAX_WARNINGS = 20  # of one log


@dataclass(frozen=True, slots=True)
class Calibrated:
    """A robot whose wheel diameters and wheelbases were fitted to recordings.

    Attributes:
        vehicle: The robot with the fitted parameters; `save_vehicle` writes it.
        trucks: Each fitted truck's calibration, with the values, their 95 % intervals and the noise.
    """

    vehicle: VehicleParameters
    trucks: Mapping[TruckName, PathCalibration]


def load_recording(folder: Path | str) -> Recording:
    """Return the recording in a folder.

    A `UserWarning` says what of the log was left out, that it ends early, or that its clock goes back.

    Raises:
        VehicleFileError: `vehicle.toml` is absent or describes no possible robot.
        LogError: `can.log` cannot be read.
        RecordingError: A file is missing, or the files contradict each other or the format.
    """
    loaded = read_recording(folder)
    for problem in islice(loaded.log.blocks.problems(), MAX_WARNINGS):
        warnings.warn(problem, stacklevel=2)
    return loaded.recording


def save_vehicle(vehicle: VehicleParameters, path: Path | str) -> None:
    """Write a `vehicle.toml` atomically; absolute paths of EDS files become relative to it.

    Raises:
        VehicleFileError: It cannot be written, for instance because its folder is not there.
    """
    try:
        write_vehicle(vehicle, path)
    except OSError as error:
        raise VehicleFileError(path, "(file)", f"cannot be written: {error.strerror or error}") from error


def calibrate(recordings: Sequence[Recording]) -> Calibrated:
    """Return the robot with the wheel diameters and wheelbases that recordings with absolute poses ask for.

    Every truck that has two absolute poses or more in a recording is fitted by least squares over its path;
    see `omnimate.calib.paths.least_squares`. Return errors of squares are one case of it.

    Args:
        recordings: Recordings of one robot, all with the same `vehicle.toml`.

    Raises:
        CalibrationError: There are no recordings, no truck has poses, or the drives cannot tell parameters.
    """
    if not recordings:
        raise CalibrationError("calibrate", "no recordings were given; expected one or more")
    vehicle = recordings[0].vehicle
    trucks = {
        name: calibrate_truck(recordings, name)
        for name in vehicle.trucks
        if any(_known_poses(recording, name) > 1 for recording in recordings)
    }
    if not trucks:
        raise CalibrationError(
            recordings[0].source, "no truck has absolute poses; record some, for instance at the stops"
        )
    fitted = {name: calibration.truck for name, calibration in trucks.items()}
    return Calibrated(corrected_vehicle(vehicle, fitted), trucks)


def _known_poses(recording: Recording, truck: TruckName) -> int:
    return 0 if recording.poses is None else len(recording.poses.of(truck).time)


def simulate(
    vehicle: VehicleParameters | None = None,
    program: Program | None = None,
    *,
    truth: Truth | None = None,
    effects: Sequence[Effect] = (),
    seed: int = 0,
    start_time: float = 0.0,
) -> Recording:
    """Return the recording of a simulated robot that drives a program; no bus is involved.

    Args:
        vehicle: The robot as its owner describes it; the reference robot, an OmniMate, by default.
        program: What to drive, from `omnimate.motion.paths`; one UMBmark square of 4 m each way by default.
        truth: The robot as it really is; by default it is as `vehicle` says, with `effects`.
        effects: Physics that `vehicle` leaves out, from `omnimate.effects`; only without `truth`.
        seed: Seed of the floor's roughness and the sensors' noise; only without `truth`.
        start_time: Time of the first sample [s].

    Raises:
        ProgramError: The program moves truck b, which the robot does not have.
        SimulationError: The program does not end, or an effect acts on what the robot does not have.
    """
    robot = reference_vehicle() if vehicle is None else vehicle
    link_length = None if robot.linkage is None else robot.linkage.length
    square = umbmark(4.0, 1, link_length=link_length) if program is None else program
    real = Truth(robot, seed=seed, effects=tuple(effects)) if truth is None else truth
    return simulate_program(robot, real, square, start_time=start_time)


def open_driver(vehicle: VehicleParameters, bus: str, flight_recorder: Path | str | None = None) -> Driver:
    """Return a driver whose encoders are configured and send; use it as a context manager.

        with omnimate.open_driver(vehicle, "socketcan://can0") as driver:
            for sample in driver.samples():
                ...

    Args:
        vehicle: The robot as its `vehicle.toml` describes it.
        bus: URL of the bus, such as `socketcan://can0`.
        flight_recorder: Folder in which the last minute before a fault is written as a recording folder;
            None for none.

    Raises:
        DriverError: The bus cannot be opened, a node is not as it must be, or an EDS that the vehicle names
            cannot be read; the bus is closed again.
    """
    descriptions = load_descriptions(vehicle)
    return open_configured(vehicle, bus, descriptions=descriptions, flight_recorder=flight_recorder)[0]
