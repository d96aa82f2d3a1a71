"""A first look, before any search: does odometry lead where the poses are, and if not, what is wrong?

The search takes effects as small, about a robot whose numbers are nearly right. Wheels that are exchanged or
count backwards, and a wheelbase of half or twice, are far outside: about such a robot a linear model finds
names for noise. They are looked for by plain odometry over short stretches, each laid onto its own poses.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import least_squares

from omnimate.mismatch.description.stretches import stretches_of
from omnimate.mismatch.description.wiring import WIRINGS, Wiring
from omnimate.vehicle.parameters import Truck

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from omnimate.mismatch.description.stretches import Stretches
    from omnimate.vehicle.parameters import TruckName
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array

GROSS = 0.05  # of the way driven, by which odometry may miss before the description is doubted
HELPS = 0.7  # of the miss, that may be left on held-out stretches by what explains it
FAR = 0.05  # by which a number is far off; the search is for what is nearer
SURE = 3.0  # standard deviations, likewise
# Factor by which nobody mistakes a number: a radius for a diameter is 2, an inch for a centimetre 2.54. What
# fits best beyond it is something else: late readings of a wheel, for example.
MISTAKEN = 3.0
AS_GOOD = 1.0  # log odds, closer than which two wirings are told as equal
_FAULTY = 1.5  # log odds against each further wheel that is exchanged or backwards
_GROUPS = 6  # of stretches that are held out in turn
_FEW = 60  # recordings that choose the wiring
_STARTS = (1.0, 2.0, 0.5)  # of the wheelbase, times the nominal one


@dataclass(frozen=True, slots=True)
class Look:
    """What a first look at one truck came to, where odometry leads far from the poses.

    Attributes:
        truck: its name.
        wiring: the likeliest.
        equals: others that explain the poses as well.
        probability: of the wiring and its equals, against all others.
        scrubs: probability that the wheelbase is as described and grows with curvature, against another one.
        ratios: (3,) effective over nominal: left diameter, right diameter, wheelbase.
        sigmas: (3,) standard deviations of them, by the jackknife over stretches.
        nominal: miss of the robot as described, root mean square over stretches of 5 s [m].
        train: likewise with the wiring and the ratios.
        heldout: likewise, each stretch with ratios fitted to others.
        shares: (4,) of the mean square that is explained, what comes back without each of the three ratios,
            and without the wiring.
    """

    truck: TruckName
    wiring: Wiring
    equals: tuple[Wiring, ...]
    probability: float
    scrubs: float
    ratios: Array
    sigmas: Array
    nominal: float
    train: float
    heldout: float
    shares: Array

    @property
    def explains(self) -> bool:
        """Whether what was found leads near the poses on unseen stretches, by numbers that one mistakes."""
        mistakable = bool(np.all(np.abs(np.log(self.ratios)) < math.log(MISTAKEN)))
        return mistakable and self.heldout < HELPS * self.nominal

    @property
    def far(self) -> NDArray[np.bool_]:
        """Which of the three ratios are far off."""
        return np.asarray(np.abs(self.ratios - 1.0) > np.maximum(FAR, SURE * self.sigmas))

    @property
    def wrong(self) -> bool:
        """Whether another description is right; else odometry leads astray by itself, on ice or by scrub."""
        scrub_alone = self.scrubs > 0.5 and not self.far[:2].any()
        return self.explains and bool(self.wiring.faults or (self.far.any() and not scrub_alone))

    def corrected(self, recording: Recording) -> Recording:
        """Return a recording whose vehicle is described as the look found it."""
        vehicle = recording.vehicle
        old, (left, right, base) = vehicle.trucks[self.truck], self.ratios.tolist()
        truck = Truck(base * old.wheelbase, left * old.wheel_diameter_left, right * old.wheel_diameter_right)
        encoders = tuple(self.wiring.rewired(one, self.truck) for one in vehicle.encoders)
        described = replace(vehicle, encoders=encoders).with_truck(self.truck, truck)
        return replace(recording, vehicle=described)


def first_look(recordings: Sequence[Recording]) -> Look | None:
    """Return what is wrong with the description of the first truck that has it wrong; None where all fit."""
    for truck in recordings[0].vehicle.trucks:
        stretches = stretches_of(recordings, truck)
        if stretches is None:
            continue
        nominal = _size(stretches.missed(stretches.turned, np.ones(3)))
        if nominal > GROSS * stretches.extent:
            few = stretches_of(recordings[:: -(-len(recordings) // _FEW)], truck)
            look = _looked(truck, stretches, few or stretches, nominal)
            if look.wrong:
                return look
    return None


def _looked(truck: TruckName, stretches: Stretches, few: Stretches, nominal: float) -> Look:
    chosen, equals, probability, near = _wired(few)
    every = np.ones(len(stretches.stretch), bool)
    ratios, cost = _fitted(stretches, chosen, every, [float(near[2])])
    heldout, sigmas = _left_out(stretches, chosen, ratios)
    scrubs = _odds(stretches, _scrubbed(stretches, chosen) / cost)
    return Look(
        truck,
        chosen,
        equals,
        probability,
        1.0 / (1.0 + math.exp(min(-scrubs, 500.0))),
        ratios,
        sigmas,
        nominal,
        math.sqrt(cost),
        heldout,
        _shares(stretches, chosen, ratios, nominal),
    )


def _shares(stretches: Stretches, wiring: Wiring, ratios: Array, nominal: float) -> Array:
    """Return which shares (4,) of what is explained come back without each ratio, and without the wiring."""
    turned, without = wiring.wheels(stretches.turned), np.where(np.eye(3), 1.0, ratios)
    missed = [stretches.missed(turned, one) for one in without] + [stretches.missed(stretches.turned, ratios)]
    costs = np.array([_size(one) for one in missed]) ** 2
    all_in = _size(stretches.missed(turned, ratios)) ** 2
    return np.asarray(np.clip((costs - all_in) / max(nominal**2 - all_in, 1e-12), 0.0, 1.0))


def _wired(stretches: Stretches) -> tuple[Wiring, tuple[Wiring, ...], float, Array]:
    """Return the likeliest wiring, those as good, the probability of them all, and the ratios (3,)."""
    every = np.ones(len(stretches.stretch), bool)
    fits = [_fitted(stretches, wiring, every, _STARTS) for wiring in WIRINGS]
    odds = np.array([_odds(stretches, cost) for _, cost in fits])
    fair = odds - _FAULTY * np.array([wiring.faults for wiring in WIRINGS])
    best = int(np.argmax(fair))
    near = np.abs(odds - odds[best]) < AS_GOOD
    weights = np.exp(fair - fair[best])
    equals = tuple(WIRINGS[at] for at in np.flatnonzero(near) if at != best)
    return WIRINGS[best], equals, float(weights[near].sum() / weights.sum()), fits[best][0]


def _odds(stretches: Stretches, cost: float) -> float:
    """Return the log likelihood of a mean square, up to a constant, where a stretch tells two numbers."""
    return -stretches.count * math.log(max(cost, 1e-12))


def _fitted(
    stretches: Stretches, wiring: Wiring, used: NDArray[np.bool_], starts: Sequence[float]
) -> tuple[Array, float]:
    """Return the ratios (3,) that miss the poses least, and the mean square of what they miss [m^2]."""
    turned = wiring.wheels(stretches.turned)

    def missed(logs: Array) -> Array:
        return stretches.missed(turned, np.exp(logs))[used].ravel()

    fits = [_least(missed, np.log([1.0, 1.0, start])) for start in starts]
    best = min(fits, key=lambda one: one[1])
    return np.exp(best[0]), best[1] / int(used.sum())


def _scrubbed(stretches: Stretches, wiring: Wiring) -> float:
    """Return the mean square miss [m^2] of the wheelbase as described, where it grows with curvature."""
    turned = wiring.wheels(stretches.turned)

    def missed(free: Array) -> Array:
        ratios = np.array([math.exp(free[0]), math.exp(free[1]), 1.0])
        return stretches.missed(turned, ratios, float(free[2])).ravel()

    return _least(missed, np.zeros(3))[1] / len(stretches.stretch)


def _least(missed: Callable[[Array], Array], start: Array) -> tuple[Array, float]:
    """Return where a sum of squares is least, and that sum; no ratio beyond a factor of 12 is tried."""
    found = least_squares(missed, start, bounds=(-2.5, 2.5), x_scale=0.1, ftol=1e-6, xtol=1e-6)
    return found.x, 2.0 * float(found.cost)


def _left_out(stretches: Stretches, wiring: Wiring, ratios: Array) -> tuple[float, Array]:
    """Return the miss on stretches left out in turn [m], and the ratios' standard deviations (3,)."""
    group = stretches.stretch % min(_GROUPS, stretches.count)
    turned, missed, found = wiring.wheels(stretches.turned), [], []
    for one in range(int(group.max()) + 1):
        others, _ = _fitted(stretches, wiring, group != one, [float(ratios[2])])
        missed.append(stretches.missed(turned, others)[group == one])
        found.append(others)
    spread = np.std(found, axis=0) * math.sqrt(max(len(found) - 1, 1))
    return _size(np.concatenate(missed)), np.asarray(spread)


def _size(missed: Array) -> float:
    """Return the root mean square length of misses (P, 3) [m]."""
    return float(np.sqrt((missed**2).sum(axis=1).mean()))
