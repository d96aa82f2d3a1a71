"""Findings of the filter besides poses: disturbed wheels, encoder errors, contradictions of the model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.ipec.filter.hypotheses import HYPOTHESES, READINGS
from omnimate.ipec.filter.prior import SUSPECT_NAMES, SUSPECT_SIZES, VALUE_NAMES, suspect_directions
from omnimate.ipec.filter.records import CREEP, FAST, JOINT_BIAS, LENGTH_BIAS, WHEEL, WHEELBASE
from omnimate.vehicle.parameters import WHEELS

if TYPE_CHECKING:
    from omnimate.vehicle.compiled import Array, Record
    from omnimate.vehicle.parameters import Channel

MIN_LOST_TRAVEL = 7e-4  # [m] smallest lost travel that is reported; false alarms amount to 0.2 mm
MIN_PROBABILITY = 0.5  # of a suspect that is reported
UNDECIDED = 0.1, 0.9  # probabilities between which a suspect is neither wrong nor right; assumption
MIN_SCATTER_FACTOR = 3.0  # [1] scatter over expected scatter that is reported (assumption)
# Of the largest size of a suspect: it would be seen at three standard deviations.
IDENTIFIABLE_FRACTION = 1.0 / 3.0
LEVELS = ("wheels of truck a", "wheels of truck b", "sides of the trucks", "slip ahead of the trucks")


@dataclass(frozen=True, slots=True)
class Disturbance:
    """An interval in which a wheel travelled less than it rolled, because of a bump or of slip."""

    wheel: Channel
    start: float  # time at which the disturbance was detected, on the recording's clock [s]
    end: float  # time of the last sample in which the wheel was distrusted, on the recording's clock [s]
    lost: float  # travel that the wheel lost [m]


def find_disturbances(time: Array, alert: Array, lost: Array) -> tuple[Disturbance, ...]:
    """Return the intervals in which distrusted wheels lost `MIN_LOST_TRAVEL` or more, in order of time.

    For samples at `time` `(N,)` [s]: `alert` is the travel for which each wheel stays distrusted after them,
    `lost` the travel that it lost in them [m], each `(N, 4)`.
    """
    disturbances = []
    for number, wheel in enumerate(WHEELS):
        marks = np.diff(np.concatenate(([0], alert[:, number] > 0.0, [0])).astype(np.int8))
        starts, ends = np.flatnonzero(marks > 0).tolist(), (np.flatnonzero(marks < 0) - 1).tolist()
        for first, last in zip(starts, ends, strict=True):
            total = float(lost[first : last + 1, number].sum())
            if total >= MIN_LOST_TRAVEL:
                disturbances.append(Disturbance(wheel, float(time[first]), float(time[last]), total))
    return tuple(sorted(disturbances, key=lambda disturbance: disturbance.start))


@dataclass(frozen=True, slots=True)
class SlowParameters:
    """The systematic errors of the encoders, as estimated."""

    wheel: Array  # true over nominal diameter of each wheel, minus 1, in the order of `WHEELS`, `(4,)`
    wheelbase: Array  # true over nominal wheelbase of truck a and truck b, minus 1, `(2,)`
    creep: Array  # sideways speed of truck a and b per lateral acceleration, outwards [s], `(2,)`
    joint_bias: Array  # bias of the readings of joint_a and joint_b [rad], `(2,)`
    link_bias: float  # bias of the link's reading [m]
    sigma: Array  # standard deviations of wheels, wheelbases, creep, joint biases and link bias, `(11,)`

    @property
    def vector(self) -> Array:
        """All of them in the order of `sigma`, shape `(11,)`."""
        return np.concatenate(
            [self.wheel, self.wheelbase, self.creep, self.joint_bias, [self.link_bias]], dtype=np.float64
        )


def slow_parameters(mean: Array, covariance: Array) -> SlowParameters:
    """Return the slow parameters in a filter's mean `(19,)` and covariance `(19, 19)`."""
    return SlowParameters(
        np.array(mean[WHEEL:WHEELBASE]),
        np.array(mean[WHEELBASE:CREEP]),
        np.array(mean[CREEP:JOINT_BIAS]),
        np.array(mean[JOINT_BIAS:LENGTH_BIAS]),
        float(mean[LENGTH_BIAS]),
        np.sqrt(np.diag(covariance))[WHEEL:],
    )


@dataclass(frozen=True, slots=True)
class Findings:
    """What contradicts the description of the robot, or the model of its motion."""

    # Probably wrong values of `vehicle.toml`, from `prior.VALUE_NAMES`, with probabilities
    suspects: tuple[tuple[str, float], ...]
    # Values of which the readings do not tell whether they are wrong, with probabilities; often several that
    # explain the same readings
    undecided: tuple[tuple[str, float], ...]
    # Readings with an error beyond a constant bias, from `hypotheses.READINGS`, with probabilities: a joint
    # with play or out of centre, a slider that sticks, a late reading, a drive that winds up
    misread: tuple[tuple[str, float], ...]
    # Inputs with more than three times the expected noise, and the ratios
    scatter: tuple[tuple[str, float], ...]
    # Suspects that this drive does not identify to a third of `prior.SUSPECT_SIZES`; the mean diameter of all
    # wheels, which the linkage never shows, counts as known
    untold: tuple[str, ...]


def findings(settings: Record, state: Record, filters: Record) -> Findings:
    """Return the findings in a state of the filter, a record `(1,)`, and its open filters."""
    likely = filters[state["weight"][0].argmax()]
    probable = tuple(zip(VALUE_NAMES, state["suspicion"][0].tolist(), strict=True))
    suspects = tuple((name, value) for name, value in probable if value >= MIN_PROBABILITY)
    undecided = tuple((name, value) for name, value in probable if UNDECIDED[0] <= value <= UNDECIDED[1])
    expected, trust, learned = settings["noise"][0], settings["trust"][0], likely["learned"]
    level = (expected * trust + learned[:, 0]) / (trust + learned[:, 1])
    factors = np.sqrt(np.divide(level, expected, out=np.zeros(4), where=expected > 0.0)).tolist()
    scatter = tuple(
        (name, value) for name, value in zip(LEVELS, factors, strict=True) if value >= MIN_SCATTER_FACTOR
    )
    return Findings(suspects, undecided, _misreading(state["weight"][0]), scatter, _unidentified(likely))


def _unidentified(likely: np.void) -> tuple[str, ...]:
    """Return the suspects that the open filter of the most probable hypothesis has not identified.

    Diameters are left out: given the mean of all wheels, the ratios of diameters contain the same
    information.
    """
    covariance = likely["covariance"][FAST:, FAST:]
    wheels = WHEELBASE - FAST
    common = covariance[:, :wheels].mean(axis=1)
    known = covariance - np.outer(common, common) / common[:wheels].mean()
    sigmas = np.sqrt(np.einsum("ij,jk,ik->i", suspect_directions(), known, suspect_directions()))
    return tuple(
        name
        for name, sigma, size in zip(SUSPECT_NAMES, sigmas.tolist(), SUSPECT_SIZES, strict=True)
        if sigma > IDENTIFIABLE_FRACTION * size and not name.startswith("diameter") and "both" not in name
    )


def _misreading(weight: Array) -> tuple[tuple[str, float], ...]:
    """Return the probably erroneous readings, by the probabilities of the hypotheses `(H,)`."""
    wandering = np.array([hypothesis.reading for hypothesis in HYPOTHESES])
    shares = [(name, float(weight[wandering == number].sum())) for number, name in enumerate(READINGS)]
    return tuple((name, share) for name, share in shares if share >= MIN_PROBABILITY)
