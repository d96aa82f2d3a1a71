"""The real robots of the OptiOdom data: calibrated on the squares, scored on every set.

The calibration sees the squares alone; `circular`, `free` and `ivanjko` are held out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from calib.apply import corrected_truck
from calib.errors import OptiOdomError
from calib.kinematics import Differential
from calib.least_squares import PathCalibration, calibrate_path
from calib.optiodom import read_optiodom
from calib.optiodom_sets import DriveSet, find_sets, read_set
from calib.reference import dead_reckoned
from calib.runs import return_errors
from calib.umbmark import solve_printed

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from calib.drives import Drive
    from calib.kinematics import Kinematics
    from vehicle.se2 import Array


@dataclass(frozen=True, slots=True)
class Score:
    """How far dead reckoning is from what was measured, over the runs of one set.

    Attributes:
        final: distance at the end, root mean square over runs [m].
        rms: distance along the way, root mean square over all samples of all runs [m].
    """

    final: float
    rms: float


@dataclass(frozen=True, slots=True)
class SetScores:
    """The scores of one set.

    Attributes:
        name: robot/path/date.
        runs: how many.
        seen: whether the calibration has seen it.
        raw: with the nominal parameters of the set.
        printed: with those of the printed UMBmark equations; None for the tricycle.
        fitted: with those of the least-squares fit.
        placed: likewise, with the markers where the squares say that they sit on the robot.
    """

    name: str
    runs: int
    seen: bool
    raw: Score
    printed: Score | None
    fitted: Score
    placed: Score


@dataclass(frozen=True, slots=True)
class RobotScores:
    """One robot: its calibration, and its scores on all sets.

    Attributes:
        kind: diff or tricyc.
        calibration: by least squares on all squares.
        printed: by the printed UMBmark equations, x and y averaged, on all squares; None for the tricycle.
        sets: in order.
    """

    kind: str
    calibration: PathCalibration
    printed: Kinematics | None
    sets: tuple[SetScores, ...]


def score_optiodom(root: Path | str) -> tuple[RobotScores, ...]:
    """Return the scores of every robot under a root that has squares.

    Raises:
        OptiOdomError: there is no set of squares, or a damaged one.
    """
    folders = find_sets(root)
    robots: dict[str, list[tuple[Path, DriveSet]]] = {}
    for folder in folders:
        data = read_set(folder)
        robots.setdefault(data.robot, []).append((folder, data))
    scored = [
        _score_robot(kind, sets)
        for kind, sets in robots.items()
        if any(data.path == "square" for _, data in sets)
    ]
    if not scored:
        raise OptiOdomError(root, "no folder square/ under it; the calibration needs squares")
    return tuple(scored)


def calibrate_squares(sets: Sequence[DriveSet]) -> PathCalibration:
    """Return the least-squares calibration on the squares among sets of one robot.

    The reference's place on the robot is estimated too: a body of markers is put on by eye.
    """
    drives = [drive for data in sets if data.path == "square" for drive in data.drives]
    nominal = next(data.kinematics for data in sets if data.path == "square")
    return calibrate_path(drives, nominal, with_offset=True)


def score(data: DriveSet, kinematics: Kinematics, lever: Array | None = None) -> Score:
    """Return the score of a model's dead reckoning on a set; `lever` `(3,)` places the markers."""
    distances = [_distances(drive, kinematics, lever) for drive in data.drives]
    finals = np.array([run[-1] for run in distances])
    every = np.concatenate(distances)
    return Score(float(np.sqrt(np.mean(finals**2))), float(np.sqrt(np.mean(every**2))))


def _distances(drive: Drive, kinematics: Kinematics, lever: Array | None) -> Array:
    away = dead_reckoned(drive, kinematics, lever) - drive.pose
    return np.asarray(np.hypot(away[:, 0], away[:, 1]), np.float64)


def _score_robot(kind: str, sets: list[tuple[Path, DriveSet]]) -> RobotScores:
    calibration = calibrate_squares([data for _, data in sets])
    printed = _printed(sets) if kind == "diff" else None
    return RobotScores(
        kind,
        calibration,
        printed,
        tuple(
            SetScores(
                data.name,
                len(data.drives),
                data.path == "square",
                score(data, data.kinematics),
                None if printed is None else score(data, printed),
                score(data, calibration.kinematics),
                score(data, calibration.kinematics, calibration.lever),
            )
            for _, data in sets
        ),
    )


def _printed(sets: list[tuple[Path, DriveSet]]) -> Kinematics:
    """Return what the printed equations, U (4.17)-(4.32), make of the runs of all squares together."""
    squares = [read_optiodom(folder) for folder, data in sets if data.path == "square"]
    truck, side = squares[0].truck, squares[0].side
    runs = [run for one in squares for run in one.runs]
    errors = return_errors(runs, truck, side, str(sets[0][0].parent))
    correction = solve_printed(errors, truck.wheelbase)
    return Differential(corrected_truck(truck, correction.e_b, correction.e_d))
