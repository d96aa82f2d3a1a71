"""The kinematic model of a differential drive for the calibration, and what any model provides.

A model works on coordinates `(P,)` that are 0 at the nominal parameters: logarithms of factors for lengths,
differences for angles. It gets the readings `(G, 2)` of its sensors on a grid of times, and returns the steps
between them with their derivatives.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from omnimate.calib.apply import corrected_truck
from omnimate.calib.estimation.chains import Coordinate, NoiseSource
from omnimate.vehicle.arcs import arc, arc_jacobian
from omnimate.vehicle.floor import floor_covariance
from omnimate.vehicle.parameters import Truck

if TYPE_CHECKING:
    from omnimate.vehicle.se2 import Array


class Steps(NamedTuple):
    """Movements between successive readings."""

    increment: Array  # each movement in the frame before it, `(N, 3)`
    jacobian: Array  # derivative of each movement by the coordinates, body frame after it, `(N, 3, P)`
    noise: Array  # its covariance per unit variance of each of C noises, the same frame, `(N, C, 3, 3)`


class Kinematics(Protocol):
    """A kinematic model with its nominal parameters."""

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The coordinates that may be estimated, in order."""

    @property
    def noises(self) -> tuple[NoiseSource, ...]:
        """The sources of noise of its movements, in order."""

    def steps(self, readings: Array, coordinates: Array) -> Steps:
        """Return the steps between readings `(G, 2)` at coordinates `(P,)`."""

    def corrected(self, coordinates: Array) -> Kinematics:
        """Return the model whose nominal parameters are those at coordinates `(P,)`."""

    def values(self, coordinates: Array) -> dict[str, float]:
        """Return the robot's parameters in SI units."""


ROUGHNESS = NoiseSource("roughness", "m/sqrt(m)", 5e-4)


@dataclass(frozen=True, slots=True)
class Differential:
    """A truck with two drive wheels; its readings are the angles of the left and the right one [rad].

    Its coordinates are those that drives identify separately: the wheelbase, the mean diameter (E_s), and the
    ratio D_R / D_L (E_d), U (2.3), (2.4). The travel of each wheel scatters independently, with the square
    root of its length (Chong & Kleeman, 1997).
    """

    truck: Truck  # nominal

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Wheelbase, mean diameter, diameter ratio."""
        return (
            Coordinate("wheelbase", "1", 0.05),
            Coordinate("mean diameter (E_s)", "1", 0.002),
            Coordinate("diameter ratio (E_d)", "1", 0.005),
        )

    @property
    def noises(self) -> tuple[NoiseSource, ...]:
        """The roughness of the floor."""
        return (ROUGHNESS,)

    def corrected(self, coordinates: Array) -> Differential:
        """Return the robot at coordinates `(3,)`."""
        return Differential(self.truck_at(coordinates))

    def truck_at(self, coordinates: Array) -> Truck:
        """Return the truck at coordinates `(3,)`."""
        e_b, e_s, e_d = np.exp(coordinates).tolist()
        truck = self.truck
        scaled = Truck(truck.wheelbase, truck.wheel_diameter_left * e_s, truck.wheel_diameter_right * e_s)
        return corrected_truck(scaled, e_b, e_d)

    def steps(self, readings: Array, coordinates: Array) -> Steps:
        """Return the steps between wheel angles `(G, 2)` [rad]; U (2.2) along exact arcs."""
        truck = self.truck_at(coordinates)
        travel = np.diff(readings, axis=0) * truck.radii
        left, right = travel.T
        ratio = truck.wheel_diameter_right / truck.wheel_diameter_left
        changes = np.zeros((len(travel), 3, 3))  # of left, right and wheelbase by each coordinate
        changes[:, 2, 0] = truck.wheelbase
        changes[:, :2, 1] = travel
        changes[:, 0, 2], changes[:, 1, 2] = -left * ratio / (ratio + 1.0), right / (ratio + 1.0)
        jacobian = arc_jacobian(left, right, truck.wheelbase)
        noise = floor_covariance(jacobian[..., :2], travel)[:, np.newaxis]
        return Steps(arc(left, right, truck.wheelbase), jacobian @ changes, noise)

    def values(self, coordinates: Array) -> dict[str, float]:
        """Return wheelbase and wheel diameters [m]."""
        truck = self.truck_at(coordinates)
        return {
            "wheelbase": truck.wheelbase,
            "left wheel diameter": truck.wheel_diameter_left,
            "right wheel diameter": truck.wheel_diameter_right,
        }
