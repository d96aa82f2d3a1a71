"""The kinematic model of OptiOdom's tricycle: one front wheel drives and steers."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from omnimate.calib.estimation.chains import Coordinate, NoiseSource
from omnimate.calib.paths.kinematics import ROUGHNESS, Steps
from omnimate.vehicle.arcs import arc, arc_derivative
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
