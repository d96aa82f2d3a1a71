"""How far physics without a name lies outside of every curve in one quantity."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from studies.mismatch.engines.strength.bound import left_of
from studies.mismatch.engines.strength.drive import WHEELS, Drive, rates

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from studies.mismatch.engines.strength.bound import Ruler

    Array = NDArray[np.float64]

KNOTS = 7  # of a curve, evenly spaced in the quantity's quantiles


def outside(change: Array, drive: Drive, ruler: Ruler) -> float:
    """Return the share of a change `(K,)` that the best curve in one quantity leaves, 0 to 1.

    A curve may scale the way of a wheel, move a truck to the left or turn it per way, or be added to a
    reading of the linkage.
    """
    return min(_left(change, drive, ruler), default=0.0)


def is_outside(change: Array, drive: Drive, ruler: Ruler, share: float) -> bool:
    """Say whether every curve in one quantity leaves a share of a change `(K,)` or more."""
    return bool(np.any(change)) and all(left >= share for left in _left(change, drive, ruler))


def _left(change: Array, drive: Drive, ruler: Ruler) -> Iterator[float]:
    """Yield the share of a change that each curve leaves."""
    whole = float(np.linalg.norm(change))
    for curve in _curves(drive) if whole > 0.0 else ():
        yield left_of(change, [ruler.change([each]) for each in curve]) / whole


def _curves(drive: Drive) -> Iterator[list[Drive]]:
    """Yield, for each curve, the drives with one of its knots raised by a little."""
    for quantity in _quantities(drive):
        knots = _knots(quantity)
        for wheel in range(2 * drive.trucks):
            yield [_scaled(drive, wheel, knot) for knot in knots]
        for truck in range(drive.trucks):
            for axis in (1, 2):
                yield [_moved(drive, truck, axis, knot) for knot in knots]
        for channel in range(drive.reading.shape[1]):
            yield [_shown(drive, channel, knot) for knot in knots]


def _quantities(drive: Drive) -> Iterator[Array]:
    """Yield what a curve may depend on, at each step, `(N - 1,)`."""
    yield drive.time[1:]
    for truck in range(drive.trucks):
        way = drive.way[:, 2 * truck : 2 * truck + 2].mean(axis=1)
        speed, acceleration = rates(way, drive.time)
        path = drive.path(truck)[1:]
        yield from (speed, np.abs(speed), acceleration, way[1:])
        yield from (rates(drive.path(truck)[:, 2], drive.time)[0], *path.T)
        yield np.mod(path[:, 2], 2.0 * np.pi)
    for wheel in range(len(WHEELS[: 2 * drive.trucks])):
        yield np.mod(drive.way[1:, wheel] / drive.radius[wheel], 2.0 * np.pi)
    yield from drive.reading[1:].T


def _knots(quantity: Array) -> list[Array]:
    """Return hats `(N - 1,)` over the range of a quantity, which sum to one."""
    places = np.unique(np.quantile(quantity, np.linspace(0.0, 1.0, KNOTS)))
    if len(places) < 2:
        return [np.ones_like(quantity)]
    return [np.interp(quantity, places, row) for row in np.eye(len(places))]


def _scaled(drive: Drive, wheel: int, knot: Array) -> Drive:
    way = drive.way[:, wheel]
    return drive.with_way(wheel, way + np.concatenate(([0.0], np.cumsum(1e-3 * knot * np.diff(way)))))


def _moved(drive: Drive, truck: int, axis: int, knot: Array) -> Drive:
    more = np.zeros((len(knot), 3))
    more[:, axis] = 1e-3 * knot * np.abs(drive.twist(truck)[:, 0])
    return drive.with_more(truck, more)


def _shown(drive: Drive, channel: int, knot: Array) -> Drive:
    return drive.with_reading(channel, drive.reading[:, channel] + 1e-3 * np.concatenate((knot[:1], knot)))
