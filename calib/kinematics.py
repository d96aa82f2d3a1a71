"""How a robot's wheels move it: what a kinematic model must tell the calibration, and the two that there are.

A model works on coordinates `(P,)` that are 0 at the nominal parameters: logarithms of factors for lengths,
differences for angles. It sees the readings `(G, 2)` of its sensors on a grid of times, and returns the steps
between them with their derivatives.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from vehicle.odometry import arc
from vehicle.parameters import Truck

if TYPE_CHECKING:
    from vehicle.se2 import Array

_SMALL = 1e-4  # [rad] below this half angle the series serve to rounding


class Steps(NamedTuple):
    """Movements between successive readings.

    Attributes:
        increment: (N, 3) each in the frame before it.
        jacobian: (N, 3, P) its derivative with respect to the coordinates, body frame after it.
        noise: (N, C, 3, 3) its covariance for each kind of noise, per unit variance, likewise.
    """

    increment: Array
    jacobian: Array
    noise: Array


class Coordinate(NamedTuple):
    """One parameter that a calibration may estimate.

    Attributes:
        name: for tables.
        unit: of the coordinate: "1" for the logarithm of a factor, rad, m, s.
        doubt: standard deviation to which it is known without any drive; wider bounds are no knowledge.
    """

    name: str
    unit: str
    doubt: float


class Noise(NamedTuple):
    """One kind of noise whose standard deviation may be estimated.

    Attributes:
        name: for tables.
        unit: of the standard deviation.
        guess: to begin with.
    """

    name: str
    unit: str
    guess: float


class Kinematics(Protocol):
    """A kinematic model with its nominal parameters."""

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """What may be estimated, in order."""

    @property
    def noises(self) -> tuple[Noise, ...]:
        """The kinds of noise of its movements, in order."""

    def steps(self, readings: Array, coordinates: Array) -> Steps:
        """Return the steps between readings `(G, 2)` at coordinates `(P,)`."""

    def corrected(self, coordinates: Array) -> Kinematics:
        """Return the model whose nominal parameters are those at coordinates `(P,)`."""

    def values(self, coordinates: Array) -> dict[str, float]:
        """Return the robot's parameters in SI units."""


ROUGHNESS = Noise("roughness", "m/sqrt(m)", 5e-4)


@dataclass(frozen=True, slots=True)
class Differential:
    """A truck with two drive wheels; its readings are the angles of the left and the right one [rad].

    Its coordinates keep apart what drives tell apart: the wheelbase, the mean diameter (E_s), and the ratio
    D_R / D_L (E_d), U (2.3), (2.4). Each wheel's travel scatters with the square root of the way,
    independently (Chong & Kleeman, 1997).

    Attributes:
        truck: nominal.
    """

    truck: Truck

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Wheelbase, mean diameter, diameter ratio."""
        return (
            Coordinate("wheelbase", "1", 0.05),
            Coordinate("mean diameter (E_s)", "1", 0.002),
            Coordinate("diameter ratio (E_d)", "1", 0.005),
        )

    @property
    def noises(self) -> tuple[Noise, ...]:
        """The roughness of the floor."""
        return (ROUGHNESS,)

    def corrected(self, coordinates: Array) -> Differential:
        """Return the robot at coordinates `(3,)`."""
        return Differential(self.truck_at(coordinates))

    def truck_at(self, coordinates: Array) -> Truck:
        """Return the truck at coordinates `(3,)`."""
        truck = self.truck
        mean = 0.5 * (truck.wheel_diameter_left + truck.wheel_diameter_right) * math.exp(coordinates[1])
        ratio = truck.wheel_diameter_right / truck.wheel_diameter_left * math.exp(coordinates[2])
        left = 2.0 * mean / (ratio + 1.0)
        return Truck(truck.wheelbase * math.exp(coordinates[0]), left, ratio * left)

    def steps(self, readings: Array, coordinates: Array) -> Steps:
        """Return the steps between wheel angles `(G, 2)` [rad]; U (2.2) along exact arcs."""
        truck = self.truck_at(coordinates)
        turned = np.diff(readings, axis=0)
        left = turned[:, 0] * (0.5 * truck.wheel_diameter_left)
        right = turned[:, 1] * (0.5 * truck.wheel_diameter_right)
        way, turn = 0.5 * (left + right), (right - left) / truck.wheelbase
        ratio = truck.wheel_diameter_right / truck.wheel_diameter_left
        change_left, change_right = -left * ratio / (ratio + 1.0), right / (ratio + 1.0)
        zero = np.zeros(len(way))
        ways = np.stack([zero, way, 0.5 * (change_left + change_right)], axis=-1)
        turns = np.stack([-turn, turn, (change_right - change_left) / truck.wheelbase], axis=-1)
        effect = arc_derivative(way, turn)
        wheels = effect @ np.array([[0.5, 0.5], [-1.0 / truck.wheelbase, 1.0 / truck.wheelbase]])
        scattered = wheels * np.sqrt(np.abs(np.stack([left, right], axis=-1)))[:, np.newaxis, :]
        return Steps(
            arc(left, right, truck.wheelbase),
            effect @ np.stack([ways, turns], axis=1),
            (scattered @ scattered.transpose(0, 2, 1))[:, np.newaxis],
        )

    def values(self, coordinates: Array) -> dict[str, float]:
        """Return wheelbase and diameters [m], with the ratio."""
        truck = self.truck_at(coordinates)
        return {
            "wheelbase": truck.wheelbase,
            "left wheel diameter": truck.wheel_diameter_left,
            "right wheel diameter": truck.wheel_diameter_right,
        }


@dataclass(frozen=True, slots=True)
class Tricycle:
    """A robot whose one front wheel drives and steers; readings are its angles: rolled and steered [rad].

    The pose is that of the middle of the rear axle: it goes forward by travel cos(steering) and turns by
    travel sin(steering) / wheelbase.

    Attributes:
        wheelbase: from the front wheel to the rear axle [m].
        wheel_diameter: of the front wheel [m].
        steering_offset: that is added to the steering reading [rad].
    """

    wheelbase: float
    wheel_diameter: float
    steering_offset: float = 0.0

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Wheelbase, wheel diameter, steering offset."""
        return (
            Coordinate("wheelbase", "1", 0.05),
            Coordinate("wheel diameter", "1", 0.01),
            Coordinate("steering offset", "rad", 0.05),
        )

    @property
    def noises(self) -> tuple[Noise, ...]:
        """The roughness of the way and of the heading."""
        return (ROUGHNESS, Noise("heading roughness", "rad/sqrt(m)", 5e-3))

    def corrected(self, coordinates: Array) -> Tricycle:
        """Return the robot at coordinates `(3,)`."""
        return Tricycle(
            self.wheelbase * math.exp(coordinates[0]),
            self.wheel_diameter * math.exp(coordinates[1]),
            self.steering_offset + float(coordinates[2]),
        )

    def steps(self, readings: Array, coordinates: Array) -> Steps:
        """Return the steps between readings `(G, 2)` [rad], each with the mean of its steering angles."""
        own = self.corrected(coordinates)
        travel = np.diff(readings[:, 0]) * (0.5 * own.wheel_diameter)
        steering = 0.5 * (readings[1:, 1] + readings[:-1, 1]) + own.steering_offset
        way, turn = travel * np.cos(steering), travel * np.sin(steering) / own.wheelbase
        zero = np.zeros(len(way))
        ways = np.stack([zero, way, -travel * np.sin(steering)], axis=-1)
        turns = np.stack([-turn, turn, travel * np.cos(steering) / own.wheelbase], axis=-1)
        effect = arc_derivative(way, turn)
        noise = np.zeros((len(way), 2, 3, 3))
        for kind, column in enumerate(effect.transpose(2, 0, 1)):
            scattered = column * np.sqrt(np.abs(travel))[:, np.newaxis]
            noise[:, kind] = scattered[:, :, np.newaxis] * scattered[:, np.newaxis, :]
        half = 0.5 * own.wheelbase * turn
        return Steps(
            arc(way - half, way + half, own.wheelbase), effect @ np.stack([ways, turns], axis=1), noise
        )

    def values(self, coordinates: Array) -> dict[str, float]:
        """Return wheelbase and diameter [m] and the steering offset [rad]."""
        own = self.corrected(coordinates)
        return {
            "wheelbase": own.wheelbase,
            "wheel diameter": own.wheel_diameter,
            "steering offset": own.steering_offset,
        }


def arc_derivative(way: Array, turn: Array) -> Array:
    """Return the derivatives `(N, 3, 2)` of arcs by their length [m] and turn [rad], body frame after them.

    The chord way sinc(h) points along the mean heading, half a turn h = turn / 2 from either end.
    """
    half = 0.5 * turn
    small = np.abs(half) < _SMALL
    safe = np.where(small, 1.0, half)
    ratio = np.where(small, 1.0 - half * half / 6.0, np.sin(half) / safe)
    slope = np.where(small, -half / 3.0, (np.cos(half) - ratio) / safe)
    cos, sin = np.cos(half), np.sin(half)
    along, across = 0.5 * way * slope, 0.5 * way * ratio
    one, zero = np.ones(len(way)), np.zeros(len(way))
    by_way = np.stack([ratio * cos, -ratio * sin, zero], axis=-1)
    by_turn = np.stack([cos * along + sin * across, cos * across - sin * along, one], axis=-1)
    return np.stack([by_way, by_turn], axis=-1)
