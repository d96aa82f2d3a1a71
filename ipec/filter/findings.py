"""What the filter reports beside the poses: disturbed wheels, the encoders' errors, and what seems wrong."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.ipec.filter.hypotheses import HYPOTHESES, READINGS
from omnimate.ipec.filter.prior import SIZES, SUSPECTED, directions
from omnimate.ipec.filter.records import CREEP, FAST, JOINT_BIAS, LENGTH_BIAS, WHEEL, WHEELBASE
from omnimate.vehicle.parameters import WHEELS

if TYPE_CHECKING:
    from omnimate.vehicle.compiled import Array, Record
    from omnimate.vehicle.parameters import Channel

NOTABLE = 7e-4  # [m] lost travel from which on a disturbance is reported; false alarms make 0.2 mm
LIKELY = 0.5  # probability from which on a suspect is named
CONTRADICTED = 3.0  # times as much as expected that inputs scatter where the model is contradicted
TOLD = 1.0 / 3.0  # of the largest size of a suspect: it would be seen at three standard deviations
LEVELS = ("wheels of truck a", "wheels of truck b", "sides of the trucks", "slip ahead of the trucks")


@dataclass(frozen=True, slots=True)
class Disturbance:
    """A stretch in which a wheel did not travel as far as it rolled, because of a bump or of slip.

    Attributes:
        wheel: Channel of the wheel.
        start: Time at which the disturbance was noticed, on the recording's clock [s].
        end: Time of the last sample in which the wheel was distrusted, on the recording's clock [s].
        lost: Travel that the wheel lost [m].
    """

    wheel: Channel
    start: float
    end: float
    lost: float


def find_disturbances(time: Array, alert: Array, lost: Array) -> tuple[Disturbance, ...]:
    """Return the stretches in which wheels were distrusted and lost `NOTABLE` or more, in order of time.

    Args:
        time: Time of each sample [s], shape `(N,)`.
        alert: Travel for which each wheel stays distrusted after each sample [m], shape `(N, 4)`.
        lost: Travel that each wheel lost in each sample [m], shape `(N, 4)`.
    """
    disturbances = []
    for number, wheel in enumerate(WHEELS):
        marks = np.diff(np.concatenate(([0], alert[:, number] > 0.0, [0])).astype(np.int8))
        starts, ends = np.flatnonzero(marks > 0).tolist(), (np.flatnonzero(marks < 0) - 1).tolist()
        for first, last in zip(starts, ends, strict=True):
            total = float(lost[first : last + 1, number].sum())
            if total >= NOTABLE:
                disturbances.append(Disturbance(wheel, float(time[first]), float(time[last]), total))
    return tuple(sorted(disturbances, key=lambda disturbance: disturbance.start))


@dataclass(frozen=True, slots=True)
class SlowParameters:
    """The systematic errors of the encoders, as estimated.

    Attributes:
        wheel: True over nominal diameter of each wheel, minus 1, in the order of `WHEELS`, shape `(4,)`.
        wheelbase: True over nominal wheelbase of truck a and truck b, minus 1, shape `(2,)`.
        creep: Sideways speed of truck a and b per lateral acceleration, outwards [s], shape `(2,)`.
        joint_bias: What joint_a and joint_b read too much [rad], shape `(2,)`.
        link_bias: What the link reads too much [m].
        sigma: Standard deviations of wheels, wheelbases, creep, joint biases and link bias, `(11,)`.
    """

    wheel: Array
    wheelbase: Array
    creep: Array
    joint_bias: Array
    link_bias: float
    sigma: Array

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
    """What contradicts the description of the robot, or the model of its motion.

    Attributes:
        suspects: What is probably wrong in `vehicle.toml`, one of `prior.SUSPECTED`, and its probability.
        misread: What reads more than an angle and a constant bias, one of `hypotheses.READINGS`, and its
            probability: a joint with play or out of centre, a slider that sticks, a late reading, a drive
            that winds up.
        scatter: What scatters more than three times as much as is expected, and how many times.
        untold: What of `prior.SUSPECTED` could be wrong by `prior.SIZES`, and the readings would not tell;
            the mean diameter of all wheels, which they never tell, counts as known.
    """

    suspects: tuple[tuple[str, float], ...]
    misread: tuple[tuple[str, float], ...]
    scatter: tuple[tuple[str, float], ...]
    untold: tuple[str, ...]


def findings(settings: Record, state: Record, filters: Record) -> Findings:
    """Return what a state of the filter, a record `(1,)`, and its open filters say beside its pose."""
    likely = filters[state["weight"][0].argmax()]
    probable = state["suspicion"][0].tolist()
    suspects = tuple(
        (name, value) for name, value in zip(SUSPECTED, probable, strict=True) if value >= LIKELY
    )
    expected, trust, learned = settings["noise"][0], settings["trust"][0], likely["learned"]
    level = (expected * trust + learned[:, 0]) / (trust + learned[:, 1])
    factors = np.sqrt(np.divide(level, expected, out=np.zeros(4), where=expected > 0.0)).tolist()
    scatter = tuple(
        (name, value) for name, value in zip(LEVELS, factors, strict=True) if value >= CONTRADICTED
    )
    return Findings(suspects, _misread(state["weight"][0]), scatter, _untold(likely))


def _untold(likely: np.void) -> tuple[str, ...]:
    """Return what the readings have not told, by the open filter of the most probable hypothesis.

    Single wheels and both wheels of a truck are left out: beside the mean of all, their ratios say the same.
    """
    covariance = likely["covariance"][FAST:, FAST:]
    wheels = WHEELBASE - FAST
    common = covariance[:, :wheels].mean(axis=1)
    known = covariance - np.outer(common, common) / common[:wheels].mean()
    sigmas = np.sqrt(np.einsum("ij,jk,ik->i", directions(), known, directions()))
    return tuple(
        name
        for name, sigma, size in zip(SUSPECTED, sigmas.tolist(), SIZES, strict=True)
        if sigma > TOLD * size and not name.startswith(("diameter", "both"))
    )


def _misread(weight: Array) -> tuple[tuple[str, float], ...]:
    """Return what probably wanders, by the probability of the hypotheses `(H,)`."""
    wandering = np.array([hypothesis.reading for hypothesis in HYPOTHESES])
    shares = [(name, float(weight[wandering == number].sum())) for number, name in enumerate(READINGS)]
    return tuple((name, share) for name, share in shares if share >= LIKELY)
