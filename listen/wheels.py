"""Classification of shafts: wheels, their trucks, joints and a slider.

While the robot drives straight, the speeds of two wheels have a constant ratio: the histogram of the
direction atan2(speed 2, speed 1) has a sharp peak off the axes.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.listen.shafts import CLOCK_STEP, effective_samples
from omnimate.listen.trucks import Trucks, find_trucks, fit_causes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from omnimate.listen.shafts import Shaft

# Assumptions on the drive and the robot; they are not fitted to data.
PEAK_HALF_WIDTH = math.radians(
    2.0
)  # [rad] of a peak: speeds of two wheels differ by 3 % when driving straight
SHORT_BITS = 16  # [bits] widest number that is a position only if it wraps
BINS = 360  # bins of the histogram, over pi
MIN_AXIS_DISTANCE = math.radians(
    12.0
)  # [rad] of a peak: counts per metre of two wheels differ less than 1 to 5
MIN_SPEED = 0.15  # relative to the 95 % quantile of a speed; slower is noise of the resolution
# Standard deviations above chance; the largest of 180 independent bins has less by chance
MIN_PEAK_SCORE = 4.0
MIN_STRAIGHT_ODDS = 2.0  # travel straight on over travel of turns on the spot
MIN_SLIDER_SHARE = 0.8  # share of the variance of a slider's rate that the trucks' speeds explain
MAX_STRAIGHT_SPREAD = 0.01  # half the relative interquartile range of a ratio while driving straight
# Relative difference of counts per metre of equal wheels: diameter, pressure, load
MAX_SCALE_DIFFERENCE = 0.02


@dataclass(frozen=True)
class Wheel:
    """A wheel."""

    shaft: Shaft  # its signals
    ratio: float  # its counts per count of the first wheel when the robot drives straight, with sign
    spread: float  # half the interquartile range of that ratio, relative to it
    truck: int | None  # number of its truck, 0 or 1; None if not identified
    # number of its side, 0 or 1; the bus does not show which is left. None if not identified
    side: int | None
    forward: int  # +1 if it counts up in the direction mostly driven, -1 if down; 0 if not identified

    @property
    def has_exact_ratio(self) -> bool:
        """Whether the ratio is that of straight travel; in a steady curve it is constant, too, but not 1."""
        return self.spread < MAX_STRAIGHT_SPREAD and abs(abs(self.ratio) - 1.0) < MAX_SCALE_DIFFERENCE


@dataclass(frozen=True)
class OtherShaft:
    """A shaft that is no wheel."""

    shaft: Shaft  # its signals
    role: str  # `joint of truck 1` or `2`, `slider`, or `cannot tell`
    share: float  # share of the variance of its rate that the wheels explain [0 to 1]; 0 if not computed


@dataclass(frozen=True)
class Kinematics:
    """Wheels, joints and slider of the robot.

    Attributes:
        wheels: Its wheels; empty if they are not identified.
        others: Its other shafts.
        reasons: Sentences on how it was decided.
        turn_starts: Times at which the first three clear turns of the robot begin [s]. A person who knows the
            direction of the first can name the sides.
        outer_side: Number of the side whose wheels travel further in the first turn; None if not identified.
        front: Number of the truck in front; None if not identified.
    """

    wheels: tuple[Wheel, ...]
    others: tuple[OtherShaft, ...]
    reasons: tuple[str, ...]
    turn_starts: tuple[float, ...] = ()
    outer_side: int | None = None
    front: int | None = None


@dataclass(frozen=True)
class _Pair:
    """Two shafts whose speeds have a constant ratio during a part of the travel."""

    ratio: float  # counts of the second shaft per count of the first one
    spread: float  # half the interquartile range of that ratio, relative to it
    share: float  # share of the travel with that ratio [0 to 1]
    straight_odds: float  # that share divided by the share of the opposite ratio (turns on the spot)


def find_wheels(shafts: Sequence[Shaft]) -> Kinematics:
    """Return the classification of shafts, whose tracks have one clock, with trucks and sides of wheels."""
    moving = [shaft for shaft in shafts if _may_be_a_wheel(shaft)]
    nodes = [shaft for shaft in moving if shaft.position.signal.node]
    moving = nodes or moving  # a vehicle.toml cannot describe signals without a node
    pairs = {
        (i, j): pair
        for i, j in itertools.combinations(range(len(moving)), 2)
        if (pair := _pair(moving[i].position.rate, moving[j].position.rate)) is not None
    }
    group = _largest_group(len(moving), pairs)
    if len(group) not in {2, 4}:
        assignment = f"{len(group)} shafts move alike" if group else "no two shafts move alike"
        others = tuple(OtherShaft(shaft, "cannot tell", 0.0) for shaft in moving)
        return Kinematics(
            (), others, (f"{assignment}: a robot has 2 or 4 wheels, so which are wheels is not identified",)
        )
    return _kinematics(moving, group, pairs)


def _may_be_a_wheel(shaft: Shaft) -> bool:
    """Return whether the rate of a shaft is far above its resolution, and its signal may be a position.

    No profile has positions of 16 bits or less; such a number is taken as one only if it wraps.
    """
    track = shaft.position
    if np.std(track.rate) <= 2 * track.noise:
        return False
    signal = track.signal
    return (
        signal.bits > SHORT_BITS or signal.counter_range > 0 or float(np.ptp(track.value)) > 2.0**signal.bits
    )


def _pair(one: NDArray[np.float64], other: NDArray[np.float64]) -> _Pair | None:
    """Return the most frequent ratio of two speeds, `(M,)`; None if none is more frequent than by chance."""
    scales = [float(np.percentile(np.abs(rate), 95)) for rate in (one, other)]
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
    histogram = np.bincount(bins, weight, BINS) / weight.sum()
    half = round(PEAK_HALF_WIDTH / math.pi * BINS)
    shares = np.sum([np.roll(histogram, shift) for shift in range(-half, half + 1)], axis=0)
    axes = np.minimum(np.mod(grid, math.pi / 2), math.pi / 2 - np.mod(grid, math.pi / 2)) < MIN_AXIS_DISTANCE
    shares[axes] = 0.0
    best = int(np.argmax(shares))
    # Most robots have equal wheels: a ratio near 1 or -1 is preferred if it has a quarter of the best share.
    equal = [
        k
        for k in range(len(grid))
        if abs(abs(math.tan(grid[k])) * scales[1] / scales[0] - 1) < 2 * MAX_SCALE_DIFFERENCE
    ]
    if equal and (like := max(equal, key=lambda k: shares[k])) and shares[like] > 0.25 * shares[best]:
        best = like
    mirror = int(np.argmin(np.abs(grid - (math.pi - grid[best]))))
    opposite_share = max(float(shares[k % len(grid)]) for k in range(mirror - half, mirror + half + 1))
    # Share of the peak if directions were evenly distributed, and its binomial standard deviation.
    expected = (2 * half + 1) / BINS
    count = effective_samples(int(np.count_nonzero(fast)))
    z = (shares[best] - expected) / math.sqrt(expected * (1 - expected) / count)
    if z < MIN_PEAK_SCORE:
        return None
    near_best = np.abs(np.mod(angle - grid[best] + math.pi / 2, math.pi) - math.pi / 2) < PEAK_HALF_WIDTH
    exact = float(np.median(y[near_best] / x[near_best])) if near_best.any() else math.tan(grid[best])
    straight_odds = float(shares[best] + 0.01) / (opposite_share + 0.01)
    same_sign = (x * y * exact > 0) & (np.abs(x) > MIN_SPEED)
    low, high = np.percentile(y[same_sign] / x[same_sign], (25, 75)) if same_sign.any() else (exact, exact)
    spread = abs(float(high - low) / 2 / exact)
    return _Pair(exact * scales[1] / scales[0], spread, float(shares[best]), straight_odds)


def _largest_group(count: int, pairs: dict[tuple[int, int], _Pair]) -> tuple[int, ...]:
    """Return the largest set of shafts of which all pairs have a constant ratio.

    Sets of 4 and 2 shafts are preferred to those of 3. Of several sets of one size, the one whose ratios hold
    over the largest mean share of the travel is returned; an empty set if there is no pair.
    """
    best: tuple[float, tuple[int, ...]] = (0.0, ())
    for size in (4, 3, 2):
        for group in itertools.combinations(range(count), size):
            found = [pairs.get(pair) for pair in itertools.combinations(group, 2)]
            if all(found):
                share = sum(pair.share for pair in found if pair) / len(found)
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
    shares = ", ".join(f"{pairs[first, other].share:.0%}" for other in group[1:])
    reasons = [f"the speeds of {len(group)} shafts have a constant ratio over {shares} of the travel: wheels"]
    net = float(np.sum(common)) / (float(np.sum(np.abs(common))) or 1.0)  # net over total travel [-1 to 1]
    forward = 0 if abs(net) < 1 / 3 or straight_odds < MIN_STRAIGHT_ODDS else int(np.sign(net))
    if straight_odds < MIN_STRAIGHT_ODDS:
        reasons.append(
            "the opposite ratio is nearly as frequent: which of the two is straight travel, and which is a "
            "turn on the spot, is not identified"
        )
    elif forward == 0:
        reasons.append("the robot drives about as far in both directions: which is forward is not identified")
    else:
        reasons.append(
            f"{(1 + abs(net)) / 2:.0%} of the travel is in one direction, which is taken as forward"
        )
    rest = [moving[k] for k in range(len(moving)) if k not in group]
    assignment = _trucks([moving[k] for k in group], ratios, rest, forward)
    trucks, sides = _trucks_and_sides(assignment, len(group))
    reasons += assignment.reasons
    spreads = [0.0, *(pairs[first, other].spread for other in group[1:])]
    wheels = tuple(
        Wheel(moving[k], ratio, spread, truck, side, int(np.sign(ratio)) * forward)
        for k, ratio, spread, truck, side in zip(group, ratios, spreads, trucks, sides, strict=True)
    )
    turn_starts, outer_side = _turns(moving[first].position.start, rates, sides, forward)
    others = _others(rest, rates, assignment)
    return Kinematics(wheels, others, tuple(reasons), turn_starts, outer_side, assignment.front)


def _trucks(wheels: Sequence[Shaft], ratios: list[float], rest: Sequence[Shaft], forward: int) -> Trucks:
    """Return the assignment of wheels to trucks, and the joints among the other shafts."""
    if len(wheels) == 2:
        why = "two wheels make one truck; only a turn of known direction identifies the left one"
        if rest:
            why = "other shafts move, too, so the two wheels may be of two trucks: this is not identified"
        return Trucks(None, has_sides=not rest, front=None, joints=(None,) * len(rest), reasons=(why,))
    rates = np.array([_smooth(wheel.position.rate) for wheel in wheels])
    nodes = [wheel.position.signal.node for wheel in wheels]
    others = [(_smooth(shaft.position.rate), shaft.position.value) for shaft in rest]
    return find_trucks(rates, ratios, nodes, others, forward)


def _trucks_and_sides(assignment: Trucks, count: int) -> tuple[list[int | None], list[int | None]]:
    """Return the truck and the side of each of `count` wheels, None if not identified.

    Without known sides, those of truck 0 are numbered 0 and 1, and those of truck 1 are None.
    """
    if count == 2:
        return ([0, 0], [0, 1]) if assignment.has_sides else ([None] * 2, [None] * 2)
    trucks: list[int | None] = [None] * count
    sides: list[int | None] = [None] * count
    for number, pair in enumerate(assignment.pairing or ()):
        for side, wheel in enumerate(pair):
            trucks[wheel] = number
            sides[wheel] = side if assignment.has_sides or number == 0 else None
    return trucks, sides


def _others(rest: Sequence[Shaft], rates: NDArray[np.float64], assignment: Trucks) -> tuple[OtherShaft, ...]:
    """Return the roles of the other shafts: joints as assigned, a slider if the trucks' speeds explain it."""
    if assignment.pairing is None:
        return tuple(OtherShaft(shaft, "cannot tell", 0.0) for shaft in rest)
    one, other = ((rates[i] + rates[j]) / 2 for i, j in assignment.pairing)
    angles = [
        shaft.position.value - shaft.position.value.mean()
        for shaft, truck in zip(rest, assignment.joints, strict=True)
        if truck is not None
    ]
    angle_terms = [one * angle for angle in angles]
    others = []
    for shaft, truck in zip(rest, assignment.joints, strict=True):
        causes = [one, other, *(one * angle**2 for angle in angles)]
        if truck is not None:
            causes = [rates[wheel] for wheel in assignment.pairing[truck]]
        causes = [_smooth(cause) for cause in (*causes, *angle_terms)]
        # Share of the variance of its rate that linear regression on the causes explains [0 to 1].
        share = max(0.0, 1.0 - fit_causes(_smooth(shaft.position.rate), [*causes, np.ones(len(one))])[0])
        role = "slider" if share > MIN_SLIDER_SHARE else "cannot tell"
        others.append(OtherShaft(shaft, role if truck is None else f"joint of truck {truck + 1}", share))
    return tuple(others)


def _smooth(rate: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the moving average over five steps of the clock."""
    return np.convolve(rate, np.ones(5) / 5, "same")


def _turns(
    start: float, rates: NDArray[np.float64], sides: list[int | None], forward: int
) -> tuple[tuple[float, ...], int | None]:
    """Return when the first three clear turns begin [s], and the outer side of the first one."""
    if None in sides:
        return (), None
    means = [rates[[k for k in range(len(rates)) if sides[k] == side]].mean(axis=0) for side in (0, 1)]
    difference = _smooth(means[1] - means[0])
    # A smaller difference may be one of the wheel diameters.
    smallest = 2 * MAX_SCALE_DIFFERENCE * float(np.percentile(np.abs(rates), 98))
    is_turn = np.abs(difference) > max(0.5 * float(np.percentile(np.abs(difference), 98)), smallest)
    starts = np.flatnonzero(is_turn[1:] & ~is_turn[:-1]) + 1
    if not len(starts):
        return (), None
    outer_side = None if forward == 0 else int(difference[starts[0]] * forward > 0)
    return tuple(start + CLOCK_STEP * number for number in starts[:3].tolist()), outer_side
