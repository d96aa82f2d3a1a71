"""Calibration by relative poses beside the Cramer-Rao bound: drives with scans that are matched.

Peer, in the same run: the closed form of Censi et al. (2013), whose equations have equal weights.

Usage: python -m studies.estimators.relative_poses [--drives 200] [--minutes 5]

Each drive goes along arcs of many radii, and turns on the spot now and then. Its wheels slip as on concrete
(5.6e-4 m/sqrt(m)), a scan is matched every second to 3 mm and 2 mrad, and robot and sensor differ from what
is believed. The error of each number over all drives is held against the bound, which is computed with the
true numbers.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass

import numpy as np

from omnimate.calib.relative.calibration import calibrate_wheels
from omnimate.calib.relative.motions import Motions
from omnimate.vehicle.arcs import arc, integrate
from omnimate.vehicle.floor import CONCRETE_ROUGHNESS
from omnimate.vehicle.parameters import Truck
from omnimate.vehicle.se2 import Array, between, compose
from studies.benchmark import options

NOMINAL = Truck(0.34, 0.15, 0.15)
SIGMA = np.array([0.003, 0.003, 0.002])  # of a matched scan [m, m, rad]
SAMPLE, SCAN = 0.02, 1.0  # [s] between samples, and between scans
SPEED = 0.5  # [m/s]
WANTED = 1.2  # error over the bound
NAMES = (
    "wheelbase [mm]",
    "left wheel [mm]",
    "right wheel [mm]",
    "sensor x [mm]",
    "sensor y [mm]",
    "yaw [mrad]",
)


@dataclass(frozen=True, slots=True)
class Simulated:
    """A drive: times, wheel angles, and the relative poses of its sensor."""

    time: Array
    readings: Array
    motions: Motions
    truth: Array


def simulated(minutes: float, chance: np.random.Generator) -> Simulated:
    """Return a drive of another robot, with another sensor."""
    factors = 1.0 + chance.normal(0.0, [0.02, 0.003, 0.003])
    truck = Truck(*(factors * [NOMINAL.wheelbase, 0.15, 0.15]))
    sensor = np.array([*chance.uniform(-0.4, 0.4, 2), chance.uniform(-math.pi, math.pi)])
    count = round(60.0 * minutes / SAMPLE)
    leg = np.arange(count) // round(3.0 / SAMPLE)  # a new arc every 3 s
    curvature = chance.uniform(-2.0, 2.0, leg[-1] + 1)[leg]
    spot = (chance.random(leg[-1] + 1) < 0.15)[leg]
    ahead = np.where(spot, 0.0, SPEED * SAMPLE)
    turn = np.where(spot, np.sign(curvature) * 0.8 * SAMPLE, SPEED * SAMPLE * curvature)
    travel = np.column_stack([ahead - 0.5 * truck.wheelbase * turn, ahead + 0.5 * truck.wheelbase * turn])
    diameters = np.array([truck.wheel_diameter_left, truck.wheel_diameter_right])
    readings = np.concatenate([np.zeros((1, 2)), np.cumsum(travel / (0.5 * diameters), axis=0)])
    gone = travel + CONCRETE_ROUGHNESS * np.sqrt(np.abs(travel)) * chance.standard_normal(travel.shape)
    path = integrate(arc(gone[:, 0], gone[:, 1], truck.wheelbase))
    time: Array = SAMPLE * np.arange(count + 1, dtype=np.float64)
    scans = np.arange(0, count + 1, round(SCAN / SAMPLE))
    seen = compose(path[scans], sensor)
    pose = compose(between(seen[:-1], seen[1:]), SIGMA * chance.standard_normal((len(scans) - 1, 3)))
    sigma = np.tile(SIGMA, (len(scans) - 1, 1))
    motions = Motions("simulated", time[scans[:-1]], time[scans[1:]], pose, sigma)
    return Simulated(time, readings, motions, np.array([truck.wheelbase, *diameters, *sensor]))


def closed_form(drive: Simulated) -> Array:
    """Return the six numbers by the closed form of Censi et al., sections V-A and V-B."""
    at = np.searchsorted(drive.time, [drive.motions.start, drive.motions.end])
    angles = drive.readings[at[1]] - drive.readings[at[0]]
    seen = drive.motions.pose
    by_left, by_right = np.linalg.lstsq(angles, seen[:, 2], rcond=None)[0]  # -r_left / b, r_right / b
    moves = []  # over the wheelbase
    for first, last in at.T:
        rolled = np.diff(drive.readings[first : last + 1], axis=0)
        steps = arc(-by_left * rolled[:, 0], by_right * rolled[:, 1], 1.0)
        moves.append(integrate(steps)[-1])
    robot = np.array(moves)
    cos, sin = np.cos(robot[:, 2]), np.sin(robot[:, 2])
    above = np.column_stack([-robot[:, 0], 1.0 - cos, sin, seen[:, 0], -seen[:, 1]])
    below = np.column_stack([-robot[:, 1], -sin, 1.0 - cos, seen[:, 1], seen[:, 0]])
    stacked = np.concatenate([above, below])
    matrix = stacked.T @ stacked
    inner = np.linalg.solve(matrix[:3, :3], matrix[:3, 3:])
    _, vectors = np.linalg.eigh(matrix[3:, 3:] - matrix[3:, :3] @ inner)
    direction = vectors[:, 0]
    rest = -inner @ direction
    if rest[0] < 0.0:
        rest, direction = -rest, -direction
    base, yaw = rest[0], math.atan2(direction[1], direction[0])
    return np.array([base, -2.0 * by_left * base, 2.0 * by_right * base, *rest[1:], yaw])


def bound(drive: Simulated) -> Array:
    """Return the Cramer-Rao bound of the six numbers: that of a fit which begins at the truth."""
    truth = drive.truth
    believed = calibrate_wheels(drive.time, drive.readings, Truck(*truth[:3]), drive.motions)
    return np.array([quantity.sigma for quantity in believed.quantities]) / max(1.0, believed.estimate.rms)


def main() -> int:
    """Print the error of each number over its bound, and how often the interval holds the truth."""
    given = options(__doc__, drives=200, minutes=5.0, seed=1)
    chance = np.random.default_rng(given.seed)
    ours, theirs, inside = [], [], []
    for _ in range(given.drives):
        drive = simulated(given.minutes, chance)
        fitted = calibrate_wheels(drive.time, drive.readings, NOMINAL, drive.motions)
        limits, truth = bound(drive), drive.truth
        values = np.array([quantity.value for quantity in fitted.quantities])
        error = np.array([_error(values, truth), _error(closed_form(drive), truth)])
        ours.append(error[0] / limits)
        theirs.append(error[1] / limits)
        reach = np.array([0.5 * (quantity.high - quantity.low) for quantity in fitted.quantities])
        inside.append(np.abs(error[0]) <= reach)
    ratios, peers = (np.sqrt((np.array(errors) ** 2).mean(axis=0)) for errors in (ours, theirs))
    print(f"{given.drives} drives of {given.minutes:g} minutes; error over the Cramer-Rao bound")
    for name, ratio, peer, part, limit in zip(
        NAMES, ratios, peers, np.mean(inside, axis=0), 1e3 * limits, strict=True
    ):
        print(
            f"{name:18s} {ratio:5.2f}, closed form {peer:6.2f}; bound {limit:7.3f}; "
            f"95 % held {100 * part:5.1f} %"
        )
    print(f"wanted: at most {WANTED:.1f}")
    return 0 if ratios.max() <= WANTED else 1


def _error(values: Array, truth: Array) -> Array:
    error = values - truth
    error[5] = math.remainder(error[5], math.tau)
    return error


if __name__ == "__main__":
    sys.exit(main())
