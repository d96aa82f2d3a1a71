"""The hall: its floor, docks and robots, drawn by chance from one seed; and any lap of any robot in it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.fleet.hall.ills import Ill
from omnimate.fleet.hall.lap import Errand, drive_lap
from omnimate.fleet.hall.places import Place, place_records
from omnimate.fleet.hall.robots import TYPES, HallRobot, draw_robot
from omnimate.vcan_sim.errors import SimulationError

if TYPE_CHECKING:
    from omnimate.fleet.hall.ills import IllKind
    from omnimate.fleet.hall.places import PlaceKind
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array

DAY = 86400.0  # [s]
FIRST_DAY = 1_772_409_600.0  # [s] 2026-03-02 00:00 UTC, a Monday
_MORNING = 6.0 * 3600.0  # [s] after midnight, when the first lap begins
_MARGIN = 1.5  # [m] that docks, points and places keep from the walls
_GRADUAL = 10  # [days] in which what comes gradually comes
_APART = 3.0  # [m] that bad places keep from each other
_STOP = 8.0  # [s] that a stop with its two turns costs beside the way

# What each kind of place costs: its reach [m], and the smallest and largest size.
_PLACES: dict[PlaceKind, tuple[float, float, float]] = {
    "joint": (0.5, 0.0015, 0.0035),
    "oil": (0.5, 0.01, 0.03),
    "slope": (0.8, 0.004, 0.010),
}
# What turns sick: components of a single robot, of a two-truck one, and the smallest and largest size.
_ILLS: dict[IllKind, tuple[tuple[str, ...], tuple[str, ...], float, float]] = {
    "wheel_diameter": (("a.left", "a.right"), ("a.left", "a.right"), 8e-4, 3e-3),
    "wheelbase": (("a",), ("a",), 1e-2, 4e-2),
    "joint_bias": ((), ("joint_a", "joint_b"), 5e-3, 2e-2),
    "wheel_eccentricity": ((), ("a.left", "a.right"), 3e-4, 1e-3),
    "gear_backlash": ((), ("a.left", "a.right"), 5e-4, 3e-3),
}


@dataclass(frozen=True, slots=True)
class Hall:
    """A hall with its robots.

    Attributes:
        length: Along x [m].
        width: Along y [m].
        docks: Docks: x [m], y [m] and heading [rad], `(M, 3)`.
        places: Bad places of the floor.
        robots: The robots.
        seed: Of all that is drawn by chance.
    """

    length: float
    width: float
    docks: Array
    places: tuple[Place, ...]
    robots: tuple[HallRobot, ...]
    seed: int


def draw_hall(
    robots: int,
    days: int,
    *,
    sick: int,
    places: int,
    docks: int = 60,
    length: float = 40.0,
    width: float = 30.0,
    sync_period: float = 0.015,
    seed: int = 0,
) -> Hall:
    """Return a hall.

    Args:
        robots: Number of robots, of three types in turn.
        days: Number of days; who turns sick does so after a fifth of them, and five days before their end.
        sick: Number of robots that turn sick, half of them gradually.
        places: Number of bad places, of three kinds in turn.
        docks: Number of docks.
        length: Of the hall, along x [m].
        width: Of the hall, along y [m].
        sync_period: Of all robots' buses [s].
        seed: Of all that is drawn by chance.

    Raises:
        SimulationError: More robots turn sick than there are, or the bad places do not fit in.
    """
    if sick > robots:
        raise SimulationError(f"{sick} sick robots of {robots}; expected no more than there are")
    chance = np.random.default_rng(seed)
    inside = np.array([length, width]) - 2.0 * _MARGIN
    positions = _MARGIN + inside * chance.uniform(size=(docks, 2))
    headings = chance.uniform(-math.pi, math.pi, docks)
    bad = _draw_places(places, inside, chance)
    chosen = set(chance.permutation(robots)[:sick].tolist())
    fleet = [
        draw_robot(
            TYPES[number % 3],
            number,
            seed,
            sync_period,
            (_draw_ill(TYPES[number % 3], days, chance),) if number in chosen else (),
        )
        for number in range(robots)
    ]
    return Hall(length, width, np.column_stack([positions, headings]), bad, tuple(fleet), seed)


def hall_lap(
    hall: Hall, robot: HallRobot, day: int, lap: int, minutes: float, pose_period: float = 0.0
) -> Recording:
    """Return the recording of a lap of a robot on a day, the same one whenever it is asked for.

    Args:
        hall: The hall.
        robot: One of its robots.
        day: From 0.
        lap: From 0.
        minutes: Time that it takes, about [min].
        pose_period: Time between readings of the pose [s]; 0 for docks alone.
    """
    chance = np.random.default_rng((hall.seed, robot.seed, day, lap))
    truth, wheels = robot.on(day, lap)
    speed = 0.9 * robot.vehicle.limits.speed
    visits, time = [int(chance.integers(len(hall.docks)))], 0.0
    while time < 60.0 * minutes:
        there = int(chance.integers(len(hall.docks) - 1))
        visits.append(there + (there >= visits[-1]))
        way = hall.docks[visits[-1], :2] - hall.docks[visits[-2], :2]
        time += float(np.hypot(*way)) / speed + _STOP
    errand = Errand(truth, wheels, hall.docks[visits], speed, pose_period, int(chance.integers(2**31)))
    start = FIRST_DAY + day * DAY + _MORNING + lap * 60.0 * (minutes + 2.0)
    return drive_lap(robot.vehicle, errand, place_records(hall.places), start)


def _draw_places(count: int, inside: Array, chance: np.random.Generator) -> tuple[Place, ...]:
    """Return bad places that keep apart from each other."""
    kinds = tuple(_PLACES)
    places: list[Place] = []
    for _ in range(1000 * count):
        if len(places) == count:
            break
        kind = kinds[len(places) % len(kinds)]
        x, y = (_MARGIN + inside * chance.uniform(size=2)).tolist()
        reach, low, high = _PLACES[kind]
        size, direction = chance.uniform(low, high), chance.uniform(-math.pi, math.pi)
        if all(math.hypot(x - other.x, y - other.y) > _APART for other in places):
            places.append(Place(kind, x, y, reach, float(size), float(direction)))
    if len(places) < count:
        raise SimulationError(f"{count} bad places, {_APART} m apart, do not fit; make the hall larger")
    return tuple(places)


def _draw_ill(kind: str, days: int, chance: np.random.Generator) -> Ill:
    """Return what goes wrong with a robot of a type."""
    column = 1 if kind == "train" else 0
    possible = [name for name, parts in _ILLS.items() if parts[column]]
    name = possible[int(chance.integers(len(possible)))]
    parts, (low, high) = _ILLS[name][column], _ILLS[name][2:]
    size = chance.uniform(low, high) * (chance.choice([-1.0, 1.0]) if "wheel_e" not in name else 1.0)
    if name == "gear_backlash":
        size = abs(size)
    first, last = max(1, days // 5), max(2, days - 5)
    day = int(chance.integers(first, last))
    gradual = int(chance.integers(2)) * min(_GRADUAL, max(2, days // 3))
    return Ill(name, str(chance.choice(parts)), day, float(size), gradual)
