"""Any set of the OptiOdom data as drives for least squares: differential robot or tricycle, any path.

A folder holds one `*_metadata.csv` and `*_run-NN.csv` files, gzipped or not: time [s], measured x, y [m] and
theta [rad], and the ticks of the right and the left wheel in that cycle, which lead to the pose of the same
row. The metadata, too, state the right diameter before the left one.
Source: Sousa et al., J Intell Robot Syst 105:39 (2022).
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from omnimate.calib.estimation.chains import Coordinate, NoiseSource
from omnimate.calib.paths.drives import Drive
from omnimate.calib.paths.kinematics import ROUGHNESS, Differential, Kinematics, Steps
from omnimate.files.errors import SourceError
from omnimate.files.importers.clock import recording_of
from omnimate.files.importers.robots import single_truck
from omnimate.files.importers.series import Series, poses_of
from omnimate.vehicle.arcs import arc, arc_derivative
from omnimate.vehicle.parameters import ParameterError, Truck, VehicleParameters
from omnimate.vehicle.recording import Direction, Lap, Recording, Run
from omnimate.vehicle.se2 import Array


@dataclass(frozen=True, slots=True)
class Tricycle:
    """A robot with a single front wheel that drives and steers.

    Its readings are the angles by which this wheel rolled and is steered [rad].

    The pose is that of the middle of the rear axle: it goes forward by travel cos(steering) and turns by
    travel sin(steering) / wheelbase.
    """

    wheelbase: float  # distance from the front wheel to the rear axle [m]
    wheel_diameter: float  # diameter of the front wheel [m]
    steering_offset: float = 0.0  # angle that is added to the steering reading [rad]

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Wheelbase, wheel diameter, steering offset."""
        return (
            Coordinate("wheelbase", "1", 0.05),
            Coordinate("wheel diameter", "1", 0.01),
            Coordinate("steering offset", "rad", 0.05),
        )

    @property
    def noises(self) -> tuple[NoiseSource, ...]:
        """The roughness of the travel and of the heading."""
        return (ROUGHNESS, NoiseSource("heading roughness", "rad/sqrt(m)", 5e-3))

    def corrected(self, coordinates: Array) -> Tricycle:
        """Return the robot at coordinates `(3,)`."""
        return Tricycle(
            self.wheelbase * math.exp(coordinates[0]),
            self.wheel_diameter * math.exp(coordinates[1]),
            self.steering_offset + float(coordinates[2]),
        )

    def steps(self, readings: Array, coordinates: Array) -> Steps:
        """Return the steps between readings `(G, 2)` [rad], each with the mean of its steering angles."""
        robot = self.corrected(coordinates)
        travel = np.diff(readings[:, 0]) * (0.5 * robot.wheel_diameter)
        steering = 0.5 * (readings[1:, 1] + readings[:-1, 1]) + robot.steering_offset
        way, turn = travel * np.cos(steering), travel * np.sin(steering) / robot.wheelbase
        zero = np.zeros(len(way))
        ways = np.stack([zero, way, -travel * np.sin(steering)], axis=-1)
        turns = np.stack([-turn, turn, travel * np.cos(steering) / robot.wheelbase], axis=-1)
        effect = arc_derivative(way, turn)
        noise = np.zeros((len(way), 2, 3, 3))
        for kind, column in enumerate(effect.transpose(2, 0, 1)):
            scattered = column * np.sqrt(np.abs(travel))[:, np.newaxis]
            noise[:, kind] = scattered[:, :, np.newaxis] * scattered[:, np.newaxis, :]
        half = 0.5 * robot.wheelbase * turn
        return Steps(
            arc(way - half, way + half, robot.wheelbase), effect @ np.stack([ways, turns], axis=1), noise
        )

    def values(self, coordinates: Array) -> dict[str, float]:
        """Return wheelbase and diameter [m] and the steering offset [rad]."""
        robot = self.corrected(coordinates)
        return {
            "wheelbase": robot.wheelbase,
            "wheel diameter": robot.wheel_diameter,
            "steering offset": robot.steering_offset,
        }


class OptiOdomError(SourceError):
    """A folder that is not the OptiOdom set that was expected, or a damaged file in it."""


def find_sets(root: Path | str) -> tuple[Path, ...]:
    """Return the folders of all sets under a root, in order; OptiOdomError where there is none."""
    root = Path(root)
    folders = sorted({file.parent for file in root.rglob("*_metadata.csv")})
    if not folders:
        raise OptiOdomError(
            root, "no *_metadata.csv under it; expected folders such as diff/square/230620202042"
        )
    return tuple(folders)


def read_metadata(folder: Path) -> dict[str, list[str]]:
    """Return the cells of a folder's metadata by their keys; OptiOdomError without one file that is read."""
    files = sorted(folder.glob("*_metadata.csv"))
    if len(files) != 1:
        raise OptiOdomError(folder, f"{len(files)} files *_metadata.csv; expected one")
    try:
        with files[0].open(encoding="utf-8", newline="") as file:
            return {row[0]: row[1:] for row in csv.reader(file) if row}
    except (OSError, UnicodeDecodeError) as error:
        raise OptiOdomError(files[0], f"cannot be read: {error}") from error


def read_numbers(folder: Path, metadata: dict[str, list[str]], key: str, count: int) -> list[float]:
    """Return the first `count` numbers of a key; OptiOdomError where fewer are positive."""
    cells = metadata.get(key, [])[:count]
    try:
        values = [float(cell) for cell in cells]
    except ValueError:
        values = []
    if len(values) < count or not all(math.isfinite(value) and value > 0.0 for value in values):
        hint = "; this is no set of squares" if key == "L" else ""
        raise OptiOdomError(folder, f"metadata {key} = {cells}; expected {count} positive number(s){hint}")
    return values


def read_rows(path: Path) -> Array:
    """Return the rows `(N, 6)` of a run; OptiOdomError where the file is damaged."""
    try:
        rows = np.loadtxt(path, delimiter=",", ndmin=2, dtype=np.float64)
    except (OSError, EOFError, ValueError) as error:
        raise OptiOdomError(path, f"damaged: {error}") from error
    if rows.shape[1] != 6 or len(rows) < 2 or not np.isfinite(rows).all():
        raise OptiOdomError(
            path,
            f"{len(rows)} rows of {rows.shape[1]} values; expected rows of t, x, y, theta, right, left, at "
            "least two, all finite",
        )
    return rows


@dataclass(frozen=True, slots=True)
class DriveSet:
    name: str  # name of the set, robot/path/date, as in the data
    robot: str  # kind of robot: diff or tricyc
    path: str  # kind of path: circular, free, ivanjko or square
    ticks_per_turn: float  # ticks of the encoders per turn of a wheel
    kinematics: Kinematics  # model of the nominal robot
    drives: tuple[Drive, ...]  # a drive for each run


def read_set(folder: Path | str) -> DriveSet:
    """Return the runs of a folder; OptiOdomError where it is no set, or a file in it is damaged."""
    folder = Path(folder).resolve()
    metadata = read_metadata(folder)
    ticks = math.prod(read_numbers(folder, metadata, key, 1)[0] for key in ("ngear", "encRes"))
    kinematics = _kinematics(folder, metadata)
    files = sorted(folder.glob("*_run-[0-9][0-9].csv*"))
    if not files:
        raise OptiOdomError(folder, "no *_run-NN.csv in it")
    drives = tuple(_drive(file, ticks, kinematics) for file in files)
    name, path = "/".join(folder.parts[-3:]), folder.parts[-2]
    return DriveSet(name, metadata["type"][0], path, ticks, kinematics, drives)


def _kinematics(folder: Path, metadata: dict[str, list[str]]) -> Kinematics:
    kind = metadata.get("type", [""])[0]
    wheelbase = read_numbers(folder, metadata, "Li", 1)[0]
    try:
        if kind == "diff":
            right, left = read_numbers(folder, metadata, "Di", 2)
            return Differential(Truck(wheelbase, left, right))
        if kind == "tricyc":
            return Tricycle(wheelbase, read_numbers(folder, metadata, "Di", 1)[0])
    except ParameterError as error:
        raise OptiOdomError(folder, str(error)) from error
    raise OptiOdomError(folder, f"robot type {kind!r}; expected diff or tricyc")


def _drive(path: Path, ticks_per_turn: float, kinematics: Kinematics) -> Drive:
    rows = read_rows(path)
    radians = 2.0 * math.pi / ticks_per_turn
    if isinstance(kinematics, Differential):
        readings = np.cumsum(rows[:, [5, 4]] * radians, axis=0)
    else:
        readings = np.stack([np.cumsum(rows[:, 4] * radians), rows[:, 5]], axis=-1)
    return Drive(rows[:, 0], readings, rows[:, 0], rows[:, 1:4], np.full((len(rows), 3), np.nan), str(path))


_PERIOD = 0.05  # [s] of the robot's cycle


def each_recording(folder: Path | str) -> Iterator[tuple[str, Recording]]:
    """Yield every run under a folder with its name, such as `diff/square/230620202042/run-01`.

    OptiOdomError where there is no set or one is damaged, SourceError where all are of the tricycle.
    """
    sets, tricycles = differential_sets(folder)
    if not sets:
        raise SourceError(
            folder,
            f"{len(tricycles)} set(s) of the tricycle; a recording folder holds differential drives only: "
            "its channels are two drive wheels, and a steered one has no place in them",
        )
    for path in sets:
        yield from _runs(path)


def differential_sets(folder: Path | str) -> tuple[list[Path], list[Path]]:
    """Return the sets of the differential robot under a folder, and those of others; as `find_sets`."""
    sets = find_sets(folder)
    differential = [path for path in sets if read_metadata(path).get("type", [""])[0] == "diff"]
    return differential, [path for path in sets if path not in differential]


def _runs(folder: Path) -> Iterator[tuple[str, Recording]]:
    data = read_set(folder)
    assert isinstance(data.kinematics, Differential)  # differential_sets chose them
    resolution = data.ticks_per_turn
    robot = single_truck("optiodom-diff", data.kinematics.truck, resolution, _PERIOD)
    is_square = data.path == "square"
    side = read_numbers(folder, read_metadata(folder), "L", 1)[0] if is_square else None
    for drive in data.drives:
        number = Path(drive.source).name.split("_run-")[1].split(".")[0]
        yield f"{data.name}/run-{number}", _recording(robot, drive, resolution, side)


def _recording(robot: VehicleParameters, drive: Drive, resolution: float, side: float | None) -> Recording:
    counts = np.rint(drive.readings * (resolution / (2.0 * math.pi)))
    left, right = (
        Series(drive.time, column, "counts", f"{drive.source}, {name}")
        for column, name in zip(counts.T, ("odoL", "odoR"), strict=True)
    )
    turned = float(counts[-1, 1] - counts[-1, 0])
    direction: Direction = "none" if side is None else "cw" if turned < 0.0 else "ccw"
    lap = Lap(direction, float(drive.time[0]), float(drive.time[-1]))
    return recording_of(
        robot,
        {"a.left": left, "a.right": right},
        drive.source,
        poses_of("a", drive.fix_time, drive.pose),
        Run("free" if side is None else "umbmark", side, (lap,)),
    )
