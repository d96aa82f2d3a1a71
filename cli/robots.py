"""Robots, truths and programs from options, and robots and profiles as results."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.cli.console import say, warn
from omnimate.vehicle.file import load_vehicle, save_vehicle

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from pathlib import Path

    from omnimate.cli.options import Protocol
    from omnimate.motion.program import Program
    from omnimate.vcan_sim.truth import Truth
    from omnimate.vehicle.parameters import Truck, TruckName, VehicleParameters


def nominal_vehicle(path: Path | None) -> VehicleParameters:
    """Return the robot of a file; without one the reference robot, after a warning."""
    from omnimate.vcan_sim.reference import reference_vehicle

    if path is not None:
        return load_vehicle(path)
    warn("no --vehicle given: taking the reference robot, a simulated OmniMate")
    return reference_vehicle()


def write_vehicle(vehicle: VehicleParameters, path: Path | None, what: str) -> None:
    """Write a robot where a file is given, and print what it is."""
    if path is not None:
        save_vehicle(vehicle, path)
        say(f"{what}: {path}")


def write_profile(profile: tuple[Path, str] | None, trucks: Mapping[TruckName, Truck]) -> None:
    """Write calibrated trucks as a profile where a file and its name are given, and print it."""
    from omnimate.calib.profiles import save_profile

    if profile is not None:
        path, name = profile
        save_profile(path, name, trucks)
        say(f"profile {name}: {path}")


def truth_of(
    vehicle: VehicleParameters,
    true_vehicle: Path | None,
    bumps: Iterable[str],
    seed: int,
    effects: Path | None = None,
) -> Truth:
    """Return the true robot of a simulation, on its floor.

    Without a file of the true robot it is the nominal one with the errors of U Fig. 11.
    """
    from omnimate.effects.file import load_effects
    from omnimate.vcan_sim.floor import Floor, parse_bump
    from omnimate.vcan_sim.truth import Truth, uncalibrated

    true = uncalibrated(vehicle) if true_vehicle is None else load_vehicle(true_vehicle)
    floor = Floor(bumps=tuple(parse_bump(text) for text in bumps))
    return Truth(true, floor=floor, seed=seed, effects=() if effects is None else load_effects(effects))


def program_of(
    protocol: Protocol, vehicle: VehicleParameters, *, side: float, runs: int, speed: float, seed: int = 0
) -> Program:
    """Return the program of a protocol.

    `side` is that of the square, the length of the straight or the rectangle, or the diameter of the eight
    [m]; `runs` are laps in each direction, or free drives; `speed` is that of the wheels [m/s].
    """
    from omnimate.motion import paths

    link = vehicle.linkage.length if vehicle.linkage is not None else None
    if protocol == "umbmark":
        return paths.umbmark(side, runs, speed=speed, link_length=link)
    if protocol == "straight":
        return paths.out_and_back(side, runs, speed=speed, link_length=link)
    if protocol == "rectangle":
        both = [*["cw"] * runs, *["ccw"] * runs]
        return paths.rounded_rectangle(side, 0.54 * side, both, tolerance=side / 12.0, speed=speed)  # type: ignore[arg-type]  # a list of the two words
    if protocol == "free":
        return paths.free(seed, runs, speed=speed)
    return paths.figure_eight(0.5 * side, runs, speed=speed)
