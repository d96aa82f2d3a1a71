"""The dimensions of the two-truck robot that `model` builds."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

WHEELS = ("a.left", "a.right", "b.left", "b.right")
FEET = (*WHEELS, "a.castor", "b.castor")


@dataclass(frozen=True, slots=True)
class Tyre:
    """One driven wheel.

    Attributes:
        radius: Radius of the tread [m].
        eccentricity: Distance of the tread's centre from the axle [m].
        phase: Phase of the eccentricity at wheel angle 0 [rad].
        softness: Time constant of the contact [s].
        creep: Time constant of the friction [s]; None for as stiff as the time step allows.
        impedance: Impedance of the contact in MuJoCo's sense; a lower one yields to forces.
    """

    radius: float
    eccentricity: float = 0.0
    phase: float = 0.0
    softness: float = 0.006
    creep: float | None = None
    impedance: float = 0.95


@dataclass(frozen=True, slots=True)
class Truck:
    """One truck.

    Attributes:
        track: Distance between the wheels' contact points [m].
        mass: Mass without wheels and payload [kg].
        castor: Place of the castor ahead of the axle [m].
        toe: Angle by which the axle is turned in the truck [rad].
        trail: Trail of the castor [m]; 0 for a ball.
        payload: Mass of a payload that can move sideways [kg].
    """

    track: float
    mass: float
    castor: float
    toe: float = 0.0
    trail: float = 0.0
    payload: float = 0.0


@dataclass(frozen=True, slots=True)
class Cable:
    """A round cable on the floor that one wheel meets.

    Attributes:
        wheel: Wheel that meets it.
        x: Place of its middle [m].
        y: Place of its middle [m].
        direction: Direction in which it lies [rad].
        height: Diameter of the cable [m].
        length: Length of the cable [m].
    """

    wheel: str
    x: float
    y: float
    direction: float
    height: float
    length: float = 0.12


@dataclass(frozen=True, slots=True)
class Robot:
    """Everything that the physics is built from.

    Attributes:
        tyres: The driven wheels, by channel.
        trucks: The trucks, by name.
        link: Length of the linkage at rest [m].
        spring: Stiffness of the slider [N/m].
        damper: Damping of the slider [N s/m].
        timestep: Step of the integration [s].
        cables: Cables on the floor.
        tilt: Slopes of the floor along x and y.
        impratio: Stiffness of friction over that of the normal force.
    """

    tyres: dict[str, Tyre]
    trucks: dict[str, Truck]
    link: float
    spring: float
    damper: float
    timestep: float = 0.0015
    cables: tuple[Cable, ...] = field(default=())
    tilt: tuple[float, float] = (0.0, 0.0)
    impratio: float = 10.0


def random_robot(rng: np.random.Generator) -> Robot:
    """Return a healthy robot of the size of CLAPPER and OmniMate, with tyres that differ slightly."""
    radius, track = rng.uniform(0.065, 0.085), rng.uniform(0.30, 0.42)
    tyres = {name: Tyre(radius * (1 + rng.normal(0, 5e-4))) for name in WHEELS}
    trucks = {
        name: Truck(track * (1 + rng.normal(0, 2e-3)), rng.uniform(18, 30), castor * rng.uniform(0.16, 0.22))
        for name, castor in (("a", 1.0), ("b", -1.0))
    }
    return Robot(tyres, trucks, rng.uniform(0.85, 1.15), rng.uniform(10, 40), rng.uniform(10, 30))
