"""Gross errors of vehicle.toml, by which plain odometry disagrees with the poses.

The search for effects linearises about a robot whose parameters are nearly right. Exchanged wheels, wheels
that count backwards, and a wheelbase of half or twice are outside of that range: there a linear model
explains noise by effects. They are looked for by plain odometry over short stretches, each aligned with its
own poses.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import least_squares

from omnimate.mismatch.description.stretches import stretches_of
from omnimate.vehicle.parameters import Truck

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from omnimate.mismatch.description.stretches import Stretches
    from omnimate.vehicle.parameters import Channel, Encoder, TruckName
    from omnimate.vehicle.recording import Recording
    from omnimate.vehicle.se2 import Array

MAX_NOMINAL_ERROR = 0.05  # [1] error of odometry over the extent of a stretch; a larger one is examined
MAX_HELDOUT_ERROR = 0.7  # [1] held-out error of an explanation over that of the robot as described
MIN_DEVIATION = 0.05  # [1] of a ratio from 1 that is gross; smaller ones are left to the search
MIN_SIGMAS = 3.0  # standard deviations of such a deviation
# [1] largest ratio that is a mistake: a radius for a diameter is 2, an inch for a centimetre 2.54. A larger
# one has another cause: late readings of a wheel, for example.
MAX_MISTAKE = 3.0
EQUAL_LOG_ODDS = 1.0  # difference of log likelihoods below which two wirings are reported as equivalent
FAULT_LOG_ODDS = 1.5  # prior log odds against each wheel that is exchanged or counts backwards; assumed
_GROUPS = 6  # of stretches that are held out in turn
_MAX_RECORDINGS = 60  # by which the wiring is chosen
_STARTS = (1.0, 2.0, 0.5)  # of the fit, for effective over nominal wheelbase


@dataclass(frozen=True, slots=True)
class Wiring:
    """Assignment of the encoders of one truck to its wheels, and their signs."""

    exchanged: bool = False  # whether left and right are exchanged
    backward: tuple[bool, bool] = (False, False)  # which of (left, right) counts down if it rolls forward

    @property
    def faults(self) -> int:
        """Number of errors in vehicle.toml that it means."""
        return self.exchanged + sum(self.backward)

    def wheels(self, turned: Array) -> Array:
        """Return the turns (N, 2) of the left and the right wheel from those described as left and right."""
        sides = turned[:, ::-1] if self.exchanged else turned
        return np.where(self.backward, -sides, sides)

    def rewired(self, encoder: Encoder, truck: TruckName) -> Encoder:
        """Return an encoder with its actual wheel and sign; those of other trucks unchanged."""
        sides: list[Channel] = ["a.left", "a.right"] if truck == "a" else ["b.left", "b.right"]
        if encoder.channel not in sides:
            return encoder
        side = sides.index(encoder.channel) ^ self.exchanged
        sign = -encoder.sign if self.backward[side] else encoder.sign
        return replace(encoder, channel=sides[side], sign=sign)

    def __str__(self) -> str:
        """Return what is wrong, in words."""
        left, right = self.backward
        words = ["left and right are exchanged"] if self.exchanged else []
        if left or right:
            which = (
                "both wheels count" if left and right else f"the {'left' if left else 'right'} wheel counts"
            )
            words.append(f"{which} backwards")
        return " and ".join(words) or "the wheels are as described"


WIRINGS = sorted(
    (
        Wiring(exchanged, (left, right))
        for exchanged, left, right in itertools.product((False, True), repeat=3)
    ),
    key=lambda wiring: wiring.faults,
)


@dataclass(frozen=True, slots=True)
class Look:
    """Best explanation of one truck's odometry, where it disagrees with the poses."""

    truck: TruckName
    wiring: Wiring  # most probable wiring
    equals: tuple[Wiring, ...]  # other wirings that explain the poses equally well
    probability: float  # probability of the wiring and its equals, among all
    scrubs: float  # probability that the wheelbase is as described, and grows with curvature
    ratios: Array  # effective over nominal left diameter, right diameter and wheelbase, `(3,)`
    sigmas: Array  # their standard deviations, by the jackknife over stretches, `(3,)`
    nominal: float  # error of the robot as described, root mean square over stretches of 5 s [m]
    train: float  # likewise with the wiring and the ratios
    heldout: float  # likewise, each stretch with ratios fitted to others
    # fractions of the explained mean square that are lost without each of the three ratios, and without the
    # wiring, `(4,)`
    shares: Array

    @property
    def far(self) -> NDArray[np.bool_]:
        """Which of the three ratios are grossly wrong, `(3,)`."""
        return np.asarray(np.abs(self.ratios - 1.0) > np.maximum(MIN_DEVIATION, MIN_SIGMAS * self.sigmas))

    @property
    def wrong(self) -> bool:
        """Whether vehicle.toml is wrong; otherwise odometry itself fails, on ice or by scrub.

        With ratios that are plausible mistakes it must reduce the held-out error.
        """
        is_plausible = bool(np.all(np.abs(np.log(self.ratios)) < math.log(MAX_MISTAKE)))
        explains = is_plausible and self.heldout < MAX_HELDOUT_ERROR * self.nominal
        scrub_alone = self.scrubs > 0.5 and not self.far[:2].any()
        return explains and bool(self.wiring.faults or (self.far.any() and not scrub_alone))

    def corrected(self, recording: Recording) -> Recording:
        """Return a recording with the corrected vehicle."""
        vehicle = recording.vehicle
        old, (left, right, base) = vehicle.trucks[self.truck], self.ratios.tolist()
        truck = Truck(base * old.wheelbase, left * old.wheel_diameter_left, right * old.wheel_diameter_right)
        encoders = tuple(self.wiring.rewired(encoder, self.truck) for encoder in vehicle.encoders)
        described = replace(vehicle, encoders=encoders).with_truck(self.truck, truck)
        return replace(recording, vehicle=described)


def first_look(recordings: Sequence[Recording]) -> Look | None:
    """Return the error of the first truck that vehicle.toml describes wrongly; None where all are right."""
    for truck in recordings[0].vehicle.trucks:
        stretches = stretches_of(recordings, truck)
        if stretches is None:
            continue
        nominal = _rms(stretches.missed(stretches.turned, np.ones(3)))
        if nominal > MAX_NOMINAL_ERROR * stretches.extent:
            few = stretches_of(recordings[:: -(-len(recordings) // _MAX_RECORDINGS)], truck)
            look = _looked(truck, stretches, few or stretches, nominal)
            if look.wrong:
                return look
    return None


def _looked(truck: TruckName, stretches: Stretches, few: Stretches, nominal: float) -> Look:
    """Return the best explanation, with the wiring that explains `few` stretches best."""
    wiring, equals, probability, of_few = _wired(few)
    ratios, cost = _fitted(stretches, wiring, [float(of_few[2])])
    heldout, sigmas = _left_out(stretches, wiring, ratios)
    scrub_log_odds = _log_likelihood(stretches, _scrubbed(stretches, wiring) / cost)
    return Look(
        truck=truck,
        wiring=wiring,
        equals=equals,
        probability=probability,
        scrubs=1.0 / (1.0 + math.exp(min(-scrub_log_odds, 500.0))),
        ratios=ratios,
        sigmas=sigmas,
        nominal=nominal,
        train=math.sqrt(cost),
        heldout=heldout,
        shares=_shares(stretches, wiring, ratios, nominal),
    )


def _shares(stretches: Stretches, wiring: Wiring, ratios: Array, nominal: float) -> Array:
    """Return the fractions (4,) of the explained mean square lost without each ratio or the wiring."""
    turned, without = wiring.wheels(stretches.turned), np.where(np.eye(3), 1.0, ratios)
    missed = [stretches.missed(turned, row) for row in without] + [stretches.missed(stretches.turned, ratios)]
    costs = np.array([_rms(errors) for errors in missed]) ** 2
    explained = _rms(stretches.missed(turned, ratios)) ** 2
    return np.asarray(np.clip((costs - explained) / max(nominal**2 - explained, 1e-12), 0.0, 1.0))


def _wired(stretches: Stretches) -> tuple[Wiring, tuple[Wiring, ...], float, Array]:
    """Return the most probable wiring, its equals, the probability of them all, and the ratios (3,)."""
    fits = [_fitted(stretches, wiring, _STARTS) for wiring in WIRINGS]
    log_likelihoods = np.array([_log_likelihood(stretches, cost) for _, cost in fits])
    log_posteriors = log_likelihoods - FAULT_LOG_ODDS * np.array([wiring.faults for wiring in WIRINGS])
    best = int(np.argmax(log_posteriors))
    equal = np.abs(log_likelihoods - log_likelihoods[best]) < EQUAL_LOG_ODDS
    weights = np.exp(log_posteriors - log_posteriors[best])
    equals = tuple(WIRINGS[at] for at in np.flatnonzero(equal) if at != best)
    return WIRINGS[best], equals, float(weights[equal].sum() / weights.sum()), fits[best][0]


def _log_likelihood(stretches: Stretches, cost: float) -> float:
    """Return the log likelihood of a mean square, up to a constant, with two independent errors a stretch."""
    return -stretches.count * math.log(max(cost, 1e-12))


def _fitted(
    stretches: Stretches,
    wiring: Wiring,
    starts: Sequence[float],
    used: NDArray[np.bool_] | slice = slice(None),
) -> tuple[Array, float]:
    """Return the ratios (3,) of least squares for some poses, and their mean square error [m^2]."""
    turned = wiring.wheels(stretches.turned)

    def missed(logs: Array) -> Array:
        return stretches.missed(turned, np.exp(logs))[used].ravel()

    fits = [_least(missed, np.log([1.0, 1.0, start])) for start in starts]
    logs, cost = min(fits, key=lambda fit: fit[1])
    return np.exp(logs), cost / len(stretches.stretch[used])


def _scrubbed(stretches: Stretches, wiring: Wiring) -> float:
    """Return the mean square error [m^2] of the described wheelbase with one that grows with curvature."""
    turned = wiring.wheels(stretches.turned)

    def missed(free: Array) -> Array:
        ratios = np.array([math.exp(free[0]), math.exp(free[1]), 1.0])
        return stretches.missed(turned, ratios, float(free[2])).ravel()

    return _least(missed, np.zeros(3))[1] / len(stretches.stretch)


def _least(missed: Callable[[Array], Array], start: Array) -> tuple[Array, float]:
    """Return where a sum of squares is least, and the sum, with ratios within a factor of exp(2.5) = 12."""
    fit = least_squares(missed, start, bounds=(-2.5, 2.5), x_scale=0.1, ftol=1e-6, xtol=1e-6)
    return fit.x, 2.0 * float(fit.cost)


def _left_out(stretches: Stretches, wiring: Wiring, ratios: Array) -> tuple[float, Array]:
    """Return the error on stretches left out in turn [m], and the ratios' standard deviations (3,)."""
    group = stretches.stretch % min(_GROUPS, stretches.count)
    turned, missed, estimates = wiring.wheels(stretches.turned), [], []
    for number in range(int(group.max()) + 1):
        of_others, _ = _fitted(stretches, wiring, [float(ratios[2])], group != number)
        missed.append(stretches.missed(turned, of_others)[group == number])
        estimates.append(of_others)
    sigmas = np.std(estimates, axis=0) * math.sqrt(max(len(estimates) - 1, 1))
    return _rms(np.concatenate(missed)), np.asarray(sigmas)


def _rms(missed: Array) -> float:
    """Return the root mean square length of errors (P, 3) [m]."""
    return float(np.sqrt((missed**2).sum(axis=1).mean()))
