"""Which robot, which truth and which program the command line means."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.cli.console import warn
from omnimate.vehicle.file import load_vehicle

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from omnimate.cli.options import Protocol
    from omnimate.motion.program import Program
    from omnimate.vcan_sim.truth import Truth
    from omnimate.vehicle.parameters import VehicleParameters


def nominal_vehicle(path: Path | None) -> VehicleParameters:
    """Return the robot of a file, or the reference robot with a word about it."""
    from omnimate.vcan_sim.reference import reference_vehicle

    if path is not None:
        return load_vehicle(path)
    warn("no --vehicle given: taking the reference robot, a simulated OmniMate")
    return reference_vehicle()


def truth_of(
    vehicle: VehicleParameters,
    true_vehicle: Path | None,
    bumps: Iterable[str],
    seed: int,
    effects: Path | None = None,
) -> Truth:
    """Return the robot as it is: of a file, or the nominal one with the errors of U Fig. 11.

    Args:
        vehicle: nominal.
        true_vehicle: file of the robot as it truly is.
        bumps: on the floor, as texts.
        seed: of chance.
        effects: file of the physics that the nominal robot leaves out.
    """
    from omnimate.effects.file import load_effects
    from omnimate.vcan_sim.bumps import parse_bump
    from omnimate.vcan_sim.floor import Floor
    from omnimate.vcan_sim.truth import Truth, uncalibrated

    true = uncalibrated(vehicle) if true_vehicle is None else load_vehicle(true_vehicle)
    floor = Floor(bumps=tuple(parse_bump(text) for text in bumps))
    return Truth(true, floor=floor, seed=seed, effects=() if effects is None else load_effects(effects))


def program_of(
    protocol: Protocol, vehicle: VehicleParameters, *, side: float, runs: int, speed: float, seed: int = 0
) -> Program:
    """Return the program of a protocol.

    Args:
        protocol: what to drive.
        vehicle: by which.
        side: of the square, length of the straight or of the rectangle, or diameter of the eight [m].
        runs: in each direction, or drives.
        speed: [m/s].
        seed: of a free drive.
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
