"""What the filter says of a robot beside its pose: what seems wrong, scatters too much, or is not told."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.ipec.filter.hypotheses import HYPOTHESES, READINGS
from omnimate.ipec.filter.prior import SIZES, SUSPECTED, directions
from omnimate.ipec.filter.records import FAST, WHEELBASE

if TYPE_CHECKING:
    from omnimate.vehicle.compiled import Array, Record

LIKELY = 0.5  # probability from which on a suspect is named
CONTRADICTED = 3.0  # times as much as expected that inputs scatter where the model is contradicted
TOLD = 1.0 / 3.0  # of the largest size of a suspect: it would be seen at three standard deviations
LEVELS = ("wheels of truck a", "wheels of truck b", "sides of the trucks", "slip ahead of the trucks")


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
    expected, trust, learned = (
        settings["noise"][0],
        settings["trust"][0],
        likely["learned"],
    )
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
