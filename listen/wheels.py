"""Classification of shafts: wheels, their trucks, joints and a slider.

While the robot drives straight, the speeds of two wheels have a constant ratio: the histogram of the
direction of the point (speed 1, speed 2) has a sharp peak off the axes.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.listen.shafts import CLOCK_STEP, effective_samples
from omnimate.listen.trucks import Trucks, find_trucks

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from omnimate.listen.shafts import Shaft

PEAK_HALF_WIDTH = math.radians(2.0)  # speeds of a wheel pair differ by 3 % when driving straight
SHORT_BITS = 16  # widest number that is a position only if it wraps
BINS = 360  # directions in half a turn
OFF_AXES = math.radians(12.0)  # of a peak; resolutions of two wheels differ by less than 1 to 5
MIN_SPEED = 0.15  # of the 95 % quantile of a speed; slower is noise of the resolution
MIN_STRAIGHT_ODDS = 2.0  # distance straight on over that of turns on the spot, as the requested drive has
MIN_SLIDER_SHARE = 0.8  # of a slider's rate, explained by the trucks' speeds; less may be chance
MAX_STRAIGHT_SPREAD = 0.01  # half interquartile range of a ratio while driving straight: wobble of the drive
MAX_SCALE_DIFFERENCE = 0.02  # relative, in counts per metre, of wheels of one make: diameter, pressure, load


@dataclass(frozen=True)
class Wheel:
    """A wheel.

    Attributes:
        shaft: Its signals.
        ratio: Its counts for each count of the first wheel when the robot drives straight on, with its sign.
        spread: Half the interquartile range of that ratio, relative to it.
        truck: Number of its truck, 0 or 1; None for `cannot tell`.
        side: Number of its side, 0 or 1: wheels of one number are on one side; None for `cannot tell`.
        forward: +1 or -1, sign that counts up in the direction mostly driven; 0 for `cannot tell`.
    """

    shaft: Shaft
    ratio: float
    spread: float
    truck: int | None
    side: int | None
    forward: int

    @property
    def has_exact_ratio(self) -> bool:
        """Whether the ratio is that of driving straight; in a steady bend it is constant too, but not 1."""
        return self.spread < MAX_STRAIGHT_SPREAD and abs(abs(self.ratio) - 1.0) < MAX_SCALE_DIFFERENCE


@dataclass(frozen=True)
class Other:
    """A movement that is not of a wheel.

    Attributes:
        shaft: Its signals.
        role: `joint of truck 1` or `2`, `slider`, or `cannot tell`.
        share: Share of its rate's variance that the wheels explain [0 to 1].
    """

    shaft: Shaft
    role: str
    share: float


@dataclass(frozen=True)
class Kinematics:
    """Wheels, joints and slider of the robot.

    Attributes:
        wheels: Its wheels.
        others: Other movements.
        reasons: Sentences on how it was decided.
        turns: Beginnings of the clearest turns [s], from which people distinguish left and right.
        ahead: Number of the side whose wheels go further forward in the first turn; None for `cannot tell`.
        front: Number of the truck in front; None for `cannot tell`.
    """

    wheels: tuple[Wheel, ...]
    others: tuple[Other, ...]
    reasons: tuple[str, ...]
    turns: tuple[float, ...] = ()
    ahead: int | None = None
    front: int | None = None


@dataclass(frozen=True)
class _Pair:
    """How two shafts move together: ratio of their speeds, and share of the distance on which it holds."""

    ratio: float
    spread: float
    share: float
    straight_odds: float  # of driving straight to turning on the spot


def find_wheels(shafts: Sequence[Shaft]) -> Kinematics:
    """Return the classification of shafts, with trucks and sides of wheels."""
    moving = [shaft for shaft in shafts if _may_be_a_wheel(shaft)]
    nodes = [shaft for shaft in moving if shaft.position.signal.node]
    moving = nodes or moving  # what no node sends has no place in a vehicle.toml
    pairs = {
        (i, j): pair
        for i, j in itertools.combinations(range(len(moving)), 2)
        if (pair := _pair(moving[i].position.rate, moving[j].position.rate)) is not None
    }
    group = _largest_group(len(moving), pairs)
    if len(group) not in {2, 4}:
        assignment = f"{len(group)} shafts move alike" if group else "no two shafts move alike"
        others = tuple(Other(shaft, "cannot tell", 0.0) for shaft in moving)
        return Kinematics(
            (), others, (f"{assignment}: a robot has 2 or 4 wheels, so which are wheels is not identified",)
        )
    return _kinematics(moving, group, pairs)


def _may_be_a_wheel(shaft: Shaft) -> bool:
    """Return whether a movement is far above its resolution, and may be a position.

    No profile has positions of 16 bits or less: such a number is one only if it goes all the way round.
    """
    track = shaft.position
    if np.std(track.rate) <= 2 * track.noise:
        return False
    signal = track.signal
    return signal.bits > SHORT_BITS or signal.turn > 0 or float(np.ptp(track.value)) > 2.0**signal.bits


def _pair(one: NDArray[np.float64], other: NDArray[np.float64]) -> _Pair | None:
    """Return the ratio of two speeds; None if no ratio is more frequent than by chance."""
    scales = [float(np.percentile(np.abs(each), 95)) for each in (one, other)]
    if not all(scales):
        return None
    x, y = one / scales[0], other / scales[1]
    fast = np.hypot(x, y) > MIN_SPEED
    if np.count_nonzero(fast) < 10:
        return None
    x, y = x[fast], y[fast]
    angle = np.mod(np.arctan2(y, x), math.pi)
    grid = (np.arange(BINS) + 0.5) * math.pi / BINS
    weight = np.hypot(x, y)
    bins = np.minimum((angle / math.pi * BINS).astype(np.int64), BINS - 1)
    each = np.bincount(bins, weight, BINS) / weight.sum()
    half = round(PEAK_HALF_WIDTH / math.pi * BINS)
    shares = np.sum([np.roll(each, shift) for shift in range(-half, half + 1)], axis=0)
    axes = np.minimum(np.mod(grid, math.pi / 2), math.pi / 2 - np.mod(grid, math.pi / 2)) < OFF_AXES
    shares[axes] = 0.0
    best = int(np.argmax(shares))
    # The wheels of most robots are alike: that ratio counts where it is held at all.
    equal = [
        k
        for k in range(len(grid))
        if abs(abs(math.tan(grid[k])) * scales[1] / scales[0] - 1) < 2 * MAX_SCALE_DIFFERENCE
    ]
    if equal and (like := max(equal, key=lambda k: shares[k])) and shares[like] > 0.25 * shares[best]:
        best = like
    mirror = int(np.argmin(np.abs(grid - (math.pi - grid[best]))))
    around = range(mirror - half, mirror + half + 1)
    against = max(float(shares[k % len(grid)]) for k in around)
    # Chance: directions spread evenly over half a turn would fall into the peak so often.
    expected = (2 * half + 1) / BINS
    count = effective_samples(int(np.count_nonzero(fast)))
    z = (shares[best] - expected) / math.sqrt(expected * (1 - expected) / count)
    if z < 4.0:  # of 180 directions some may be as frequent by chance with less
        return None
    near_best = np.abs(np.mod(angle - grid[best] + math.pi / 2, math.pi) - math.pi / 2) < PEAK_HALF_WIDTH
    exact = float(np.median(y[near_best] / x[near_best])) if near_best.any() else math.tan(grid[best])
    straight_odds = float(shares[best] + 0.01) / (against + 0.01)
    alike = (x * y * exact > 0) & (np.abs(x) > MIN_SPEED)
    low, high = np.percentile(y[alike] / x[alike], (25, 75)) if alike.any() else (exact, exact)
    spread = abs(float(high - low) / 2 / exact)
    return _Pair(exact * scales[1] / scales[0], spread, float(shares[best]), straight_odds)


def _largest_group(count: int, pairs: dict[tuple[int, int], _Pair]) -> tuple[int, ...]:
    """Return the largest set of shafts of which all pairs move alike; of equal ones that which does most."""
    best: tuple[float, tuple[int, ...]] = (0.0, ())
    for size in (4, 3, 2):
        for group in itertools.combinations(range(count), size):
            held = [pairs.get(pair) for pair in itertools.combinations(group, 2)]
            if all(held):
                share = sum(pair.share for pair in held if pair) / len(held)
                best = max(best, (share, group))
        if best[1] and size != 3:
            return best[1]
    return best[1]


def _kinematics(
    moving: Sequence[Shaft], group: tuple[int, ...], pairs: dict[tuple[int, int], _Pair]
) -> Kinematics:
    first = group[0]
    ratios = [1.0, *(pairs[first, other].ratio for other in group[1:])]
    straight_odds = min(pairs[first, other].straight_odds for other in group[1:])
    rates = np.array([moving[k].position.rate / ratio for k, ratio in zip(group, ratios, strict=True)])
    common = rates.mean(axis=0)
    held = ", ".join(f"{pairs[first, other].share:.0%}" for other in group[1:])
    reasons = [f"{len(group)} shafts hold one ratio of their speeds over {held} of the travel: wheels"]
    going = float(np.sum(common)) / (float(np.sum(np.abs(common))) or 1.0)
    forward = 0 if abs(going) < 1 / 3 or straight_odds < MIN_STRAIGHT_ODDS else int(np.sign(going))
    if straight_odds < MIN_STRAIGHT_ODDS:
        reasons.append(
            "the opposite ratio is held nearly as long: which of the two is straight on, and which is a turn "
            "on the spot, is not identified"
        )
    elif forward == 0:
        reasons.append(
            "it drives about as far in both directions: which direction is forward is not identified"
        )
    else:
        reasons.append(
            f"{(1 + abs(going)) / 2:.0%} of the travel is in one direction, which is taken as forward"
        )
    rest = [moving[k] for k in range(len(moving)) if k not in group]
    assignment = _trucks([moving[k] for k in group], ratios, rest, forward)
    trucks, sides = _places(assignment, len(group))
    reasons += assignment.reasons
    spreads = [0.0, *(pairs[first, other].spread for other in group[1:])]
    wheels = tuple(
        Wheel(moving[k], ratio, spread, truck, side, int(np.sign(ratio)) * forward)
        for k, ratio, spread, truck, side in zip(group, ratios, spreads, trucks, sides, strict=True)
    )
    turns, ahead = _turns(moving[first].position.start, rates, sides, forward)
    others = _others(rest, rates, assignment)
    return Kinematics(wheels, others, tuple(reasons), turns, ahead, assignment.front)


def _trucks(wheels: Sequence[Shaft], ratios: list[float], rest: Sequence[Shaft], forward: int) -> Trucks:
    """Return the assignment of wheels to trucks, and the joints among the other shafts."""
    nothing: tuple[int | None, ...] = (None,) * len(rest)
    if len(wheels) == 2:
        why = "two wheels make one truck; only a turn of known direction identifies the left one"
        if rest:
            why = "other shafts move, too, so these two may be wheels of two trucks: cannot tell"
        return Trucks(None, has_sides=not rest, front=None, joints=nothing, reasons=(why,))
    rates = np.array([_smooth(wheel.position.rate) for wheel in wheels])
    nodes = [wheel.position.signal.node for wheel in wheels]
    others = [(_smooth(shaft.position.rate), shaft.position.value) for shaft in rest]
    return find_trucks(rates, ratios, nodes, others, forward)


def _places(assignment: Trucks, count: int) -> tuple[list[int | None], list[int | None]]:
    """Return truck and side of each wheel."""
    if count == 2:
        return ([0, 0], [0, 1]) if assignment.has_sides else ([None] * 2, [None] * 2)
    trucks: list[int | None] = [None] * count
    sides: list[int | None] = [None] * count
    for number, pair in enumerate(assignment.pairing or ()):
        for side, wheel in enumerate(pair):
            trucks[wheel] = number
            sides[wheel] = side if assignment.has_sides or number == 0 else None
    return trucks, sides


def _others(rest: Sequence[Shaft], rates: NDArray[np.float64], assignment: Trucks) -> tuple[Other, ...]:
    """Return the roles of the other movements: joints by their law, a slider by the trucks' speeds."""
    if assignment.pairing is None:
        return tuple(Other(shaft, "cannot tell", 0.0) for shaft in rest)
    one, other = ((rates[i] + rates[j]) / 2 for i, j in assignment.pairing)
    angles = [
        shaft.position.value - shaft.position.value.mean()
        for shaft, truck in zip(rest, assignment.joints, strict=True)
        if truck is not None
    ]
    bent = [one * angle for angle in angles]
    others = []
    for shaft, truck in zip(rest, assignment.joints, strict=True):
        causes = [one, other, *(one * angle**2 for angle in angles)]
        if truck is not None:
            causes = [rates[wheel] for wheel in assignment.pairing[truck]]
        share = _share(_smooth(shaft.position.rate), [_smooth(cause) for cause in (*causes, *bent)])
        if truck is not None:
            others.append(Other(shaft, f"joint of truck {truck + 1}", share))
        else:
            others.append(Other(shaft, "slider" if share > MIN_SLIDER_SHARE else "cannot tell", share))
    return tuple(others)


def _smooth(rate: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.convolve(rate, np.ones(5) / 5, "same")


def _share(rate: NDArray[np.float64], causes: Sequence[NDArray[np.float64]]) -> float:
    """Return the share of a rate's variance that causes explain linearly."""
    table = np.array([*causes, np.ones(len(rate))]).T
    left = rate - table @ np.linalg.lstsq(table, rate, rcond=None)[0]
    whole = float(np.var(rate))
    return max(0.0, 1.0 - float(np.var(left)) / whole) if whole else 0.0


def _turns(
    start: float, rates: NDArray[np.float64], sides: list[int | None], forward: int
) -> tuple[tuple[float, ...], int | None]:
    """Return when the clearest turns begin, and which side goes further forward in the first of them."""
    if None in sides:
        return (), None
    sums = [rates[[k for k in range(len(rates)) if sides[k] == side]].mean(axis=0) for side in (0, 1)]
    difference = _smooth(sums[1] - sums[0])
    least = (
        2 * MAX_SCALE_DIFFERENCE * float(np.percentile(np.abs(rates), 98))
    )  # less may be a difference of diameters
    fast = np.abs(difference) > max(0.5 * float(np.percentile(np.abs(difference), 98)), least)
    starts = np.flatnonzero(fast[1:] & ~fast[:-1]) + 1
    if not len(starts):
        return (), None
    ahead = None if forward == 0 else int(difference[starts[0]] * forward > 0)
    return tuple(start + CLOCK_STEP * number for number in starts[:3].tolist()), ahead
