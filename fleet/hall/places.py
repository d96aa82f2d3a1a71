"""Bad places of a hall's floor, and their effect on a robot that drives over them."""

import math
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from omnimate.vcan_sim.errors import SimulationError
from omnimate.vcan_sim.records import Constants, State
from omnimate.vehicle.compiled import Array, Record, compiled, layout
from omnimate.vehicle.se2 import transform_xy

PlaceKind = Literal["joint", "oil", "slope"]
KINDS: tuple[PlaceKind, ...] = get_args(PlaceKind)
JOINT, OIL, SLOPE = range(3)
_MIN_DISTANCE = 3.0  # [m] between the centres of two bad places (assumption)
# For each kind: reach [m], and range of the size in the unit of `Place.size`. Assumptions.
_RANGES: dict[PlaceKind, tuple[float, float, float]] = {
    "joint": (0.5, 0.0015, 0.0035),
    "oil": (0.5, 0.01, 0.03),
    "slope": (0.8, 0.004, 0.010),
}


@dataclass(frozen=True, slots=True)
class Place:
    """A bad place of the floor.

    Raises:
        SimulationError: The kind is not known, or the reach is not positive.
    """

    # `joint` between slabs: a line, at each crossing of which a wheel loses travel; `oil`: a disc on which
    # wheels slip; `slope`: a disc on which trucks creep
    kind: PlaceKind
    x: float  # x of its centre [m]
    y: float  # y of its centre [m]
    reach: float  # half the length of a joint, or the radius of an oily patch or slope [m]
    # travel lost at a crossing of a joint [m], fraction of the travel lost on oil [1], or creep per metre of
    # travel on a slope [1]
    size: float
    direction: float = 0.0  # direction of the joint's line, or of the creep [rad]; not used for oil

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise SimulationError(f"a place of kind {self.kind!r}; expected one of {', '.join(KINDS)}")
        if not self.reach > 0.0:
            raise SimulationError(f"a place of reach {self.reach} m; expected more than 0")


class PlaceRecord:
    """A place for compiled code: `kind` is its number in `KINDS`, cos and sin are of its direction."""

    kind: int
    x: float
    y: float
    reach: float
    size: float
    cos: float
    sin: float


def draw_places(count: int, margin: float, inside: Array, chance: np.random.Generator) -> tuple[Place, ...]:
    """Return random bad places, at least `_MIN_DISTANCE` apart.

    They lie in an area with sides `inside` [m], `(2,)`, at a distance `margin` [m] from the walls.

    Raises:
        SimulationError: They do not fit into that area.
    """
    places: list[Place] = []
    for _ in range(1000 * count):
        if len(places) == count:
            break
        kind = KINDS[len(places) % len(KINDS)]
        x, y = (margin + inside * chance.uniform(size=2)).tolist()
        reach, low, high = _RANGES[kind]
        size, direction = chance.uniform(low, high), chance.uniform(-math.pi, math.pi)
        if all(math.hypot(x - other.x, y - other.y) > _MIN_DISTANCE for other in places):
            places.append(Place(kind, x, y, reach, float(size), float(direction)))
    if len(places) < count:
        raise SimulationError(
            f"{count} bad places, {_MIN_DISTANCE} m apart, do not fit; make the hall larger"
        )
    return tuple(places)


def place_records(places: tuple[Place, ...]) -> Record:
    """Return one record for each place, `(K,)`."""
    rows = [
        (
            KINDS.index(place.kind),
            place.x,
            place.y,
            place.reach,
            place.size,
            math.cos(place.direction),
            math.sin(place.direction),
        )
        for place in places
    ]
    return np.array(rows, layout(PlaceRecord))


@compiled
def lose_travel(places: Record, sides: Array, constants: Constants, state: State) -> None:
    """Reduce the wheels' travel in this step by the loss on joints and oily patches.

    `sides` are the signed distances of each wheel from the line of each of the K places in the previous step
    [m], `(K, 4)`; they are updated, and the state's `travel` is changed.
    """
    for wheel in range(2 * constants.trucks):
        truck = wheel // 2
        x, y = transform_xy(state.pose[truck], 0.0, constants.wheelbase[truck] * (0.5 - wheel % 2))
        for number in range(len(places)):
            place = places[number]
            from_x, from_y = x - place.x, y - place.y
            if place.kind == JOINT:
                side = place.cos * from_y - place.sin * from_x
                along = place.cos * from_x + place.sin * from_y
                if side * sides[number, wheel] < 0.0 and abs(along) <= place.reach:
                    state.travel[wheel] -= math.copysign(place.size, state.travel[wheel])
                sides[number, wheel] = side
            elif place.kind == OIL and from_x * from_x + from_y * from_y <= place.reach * place.reach:
                state.travel[wheel] *= 1.0 - place.size


@compiled
def creep_on_slopes(places: Record, constants: Constants, state: State) -> None:
    """Shift each truck on a slope in the slope's direction, in proportion to its travel in this step."""
    for truck in range(constants.trucks):
        travel = abs(0.5 * (state.travel[2 * truck] + state.travel[2 * truck + 1]))
        for number in range(len(places)):
            place = places[number]
            from_x, from_y = state.pose[truck, 0] - place.x, state.pose[truck, 1] - place.y
            if place.kind == SLOPE and from_x * from_x + from_y * from_y <= place.reach * place.reach:
                state.pose[truck, 0] += place.size * travel * place.cos
                state.pose[truck, 1] += place.size * travel * place.sin
