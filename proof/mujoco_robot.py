"""The measures of the two-truck robot that `mujoco_model` builds."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

WHEELS = ("a.left", "a.right", "b.left", "b.right")
FEET = (*WHEELS, "a.castor", "b.castor")


@dataclass(frozen=True, slots=True)
class Tyre:
    """One driven wheel: radius, eccentricity [m], its phase at zero [rad], contact time constant [s]."""

    radius: float
    eccentricity: float = 0.0
    phase: float = 0.0
    softness: float = 0.006
    creep: float | None = None  # time constant [s] of the friction; None: as stiff as the time step allows
    impedance: float = 0.95  # of the contact in MuJoCo's sense; lower gives way to forces


@dataclass(frozen=True, slots=True)
class Truck:
    """One truck: track [m], axle turned by toe [rad], masses [kg], castor's place [m] and trail [m]."""

    track: float
    mass: float
    castor: float
    toe: float = 0.0
    trail: float = 0.0
    payload: float = 0.0


@dataclass(frozen=True, slots=True)
class Cable:
    """A round cable on the floor, met by one wheel: place [m], direction [rad], height and length [m]."""

    wheel: str
    x: float
    y: float
    direction: float
    height: float
    length: float = 0.12


@dataclass(frozen=True, slots=True)
class Robot:
    """Everything that the physics is built from; `link` is the linkage's length at rest [m]."""

    tyres: dict[str, Tyre]
    trucks: dict[str, Truck]
    link: float
    spring: float
    damper: float
    timestep: float = 0.0015
    cables: tuple[Cable, ...] = field(default=())
    tilt: tuple[float, float] = (0.0, 0.0)
    impratio: float = 10.0  # stiffness of friction by that of the normal force


def random_robot(rng: np.random.Generator) -> Robot:
    """Return a healthy robot of the CLAPPER's and OmniMate's size, its tyres a little unlike each other."""
    radius, track = rng.uniform(0.065, 0.085), rng.uniform(0.30, 0.42)
    tyres = {name: Tyre(radius * (1 + rng.normal(0, 5e-4))) for name in WHEELS}
    trucks = {
        name: Truck(track * (1 + rng.normal(0, 2e-3)), rng.uniform(18, 30), castor * rng.uniform(0.16, 0.22))
        for name, castor in (("a", 1.0), ("b", -1.0))
    }
    return Robot(tyres, trucks, rng.uniform(0.85, 1.15), rng.uniform(10, 40), rng.uniform(10, 30))
