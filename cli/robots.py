"""Which robot, which truth and which program the command line means."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING

from cli.console import warn
from vehicle.errors import OmnimateError
from vehicle.file import load_vehicle

if TYPE_CHECKING:
    from collections.abc import Iterable

    from motion.program import Program
    from vcan_sim.bumps import Bump
    from vcan_sim.truth import Truth
    from vehicle.parameters import VehicleParameters

_BUMP = {
    "wheel": str, "after": float, "lap": int, "x": float, "y": float, "size": float, "height": float,
    "shape": str,
}  # fmt: skip


class BumpError(OmnimateError):
    """A bump that the command line describes wrongly.

    Attributes:
        text: as it was given.
    """

    def __init__(self, text: str, problem: str) -> None:
        super().__init__(f"bump {text!r}: {problem}")
        self.text = text


class Protocol(Enum):
    """What to drive."""

    umbmark = "umbmark"
    straight = "straight"
    rectangle = "rectangle"
    free = "free"
    eight = "eight"


def nominal_vehicle(path: Path | None) -> VehicleParameters:
    """Return the robot of a file, or the reference robot with a word about it."""
    from vcan_sim.reference import reference_vehicle

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
    from vcan_sim.effects.file import load_effects
    from vcan_sim.floor import Floor
    from vcan_sim.truth import Truth, uncalibrated

    true = uncalibrated(vehicle) if true_vehicle is None else load_vehicle(true_vehicle)
    floor = Floor(bumps=tuple(parse_bump(text) for text in bumps))
    return Truth(true, floor=floor, seed=seed, effects=() if effects is None else load_effects(effects))


def parse_bump(text: str) -> Bump:
    """Return the bump that a text such as `wheel=a.right,after=3,height=0.01` describes.

    Raises:
        BumpError: an unknown key, or a value that is none.
    """
    from vcan_sim.bumps import Bump

    values: dict[str, object] = {}
    for pair in text.split(","):
        key, equals, value = pair.partition("=")
        if key not in _BUMP or not equals:
            raise BumpError(text, f"{pair!r} is not understood; expected key=value with {', '.join(_BUMP)}")
        try:
            values[key] = _BUMP[key](value)
        except ValueError:
            raise BumpError(text, f"{pair}: expected a number") from None
    try:
        return Bump(**values)  # type: ignore[arg-type]  # of the fields' own types, by the table above
    except OmnimateError as error:
        raise BumpError(text, str(error)) from error


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
    from motion import paths

    link = vehicle.linkage.length if vehicle.linkage is not None else None
    if protocol is Protocol.umbmark:
        return paths.umbmark(side, runs, speed=speed, link_length=link)
    if protocol is Protocol.straight:
        return paths.out_and_back(side, runs, speed=speed, link_length=link)
    if protocol is Protocol.rectangle:
        both = [*["cw"] * runs, *["ccw"] * runs]
        return paths.rounded_rectangle(side, 0.54 * side, both, tolerance=side / 12.0, speed=speed)  # type: ignore[arg-type]  # a list of the two words
    if protocol is Protocol.free:
        return paths.free(seed, runs, speed=speed)
    return paths.figure_eight(0.5 * side, runs, speed=speed)
