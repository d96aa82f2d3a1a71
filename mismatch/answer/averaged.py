"""A calibration whose numbers count as much as the recordings need them.

Where a drive hardly tells a truck's numbers, those of `vehicle.toml` lead as well as a fit does. Between the
robot as described and the calibrated one, both as likely a priori, the answer is the mean of the two, each
weighed by its probability (Bayesian model averaging: Hoeting, Madigan, Raftery and Volinsky, Statistical
Science 1999).
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import expit, logsumexp

from omnimate.mismatch.candidates.regression import slices_of
from omnimate.mismatch.evidence.density import log_evidence
from omnimate.mismatch.fit import prior_of

if TYPE_CHECKING:
    from omnimate.mismatch.fit import Acting, Fitted
    from omnimate.vehicle.se2 import Array

# Declared ones, of what a robot that was never calibrated is off by: per cent to per mille.
SIZES = (1.0, 0.3, 0.1)


def averaged(fit: Fitted) -> Acting:
    """Return what is calibrated beside the findings; how references are mounted is as fitted."""
    acting = fit.calibrated
    numbers = [number for number, term in enumerate(acting.terms) if not term.is_setup]
    if not numbers:
        return acting
    share = _needed(fit, numbers)
    values, effects, covariance = list(acting.values), list(acting.effects), acting.covariance.copy()
    parts = slices_of(map(len, acting.values))
    inside = np.concatenate([np.arange(parts[number].start, parts[number].stop) for number in numbers])
    fitted = np.concatenate(acting.values)[inside]
    block = np.ix_(inside, inside)
    covariance[block] = share * covariance[block] + share * (1.0 - share) * np.outer(fitted, fitted)
    for number in numbers:
        values[number] = share * values[number]
        effects[number] = acting.terms[number].built(values[number])
    return replace(acting, values=tuple(values), effects=tuple(effects), covariance=covariance)


def _needed(fit: Fitted, numbers: list[int]) -> float:
    """Return the probability of the robot with calibrated numbers, against the one that is described."""
    everything = list(fit.everything())
    columns, data = fit.linear_model(fit.rows)
    widths = [len(values) for _, _, values in everything]
    first = len(fit.chosen.terms)
    without = np.repeat([at - first not in numbers for at in range(len(everything))], widths)
    prior = prior_of([term for term, _, _ in everything], first)
    gram, score = columns.T @ columns, columns.T @ data
    lesser = np.ix_(without, without)
    gains = []
    for size in SIZES:
        scale = np.where(without, 1.0, size)
        gains.append(_evidence(gram, score, prior / np.outer(scale, scale)))
    nothing = _evidence(gram[lesser], score[without], prior[lesser])
    return float(expit(logsumexp(gains) - math.log(len(SIZES)) - nothing))


def _evidence(gram: Array, score: Array, prior: Array) -> float:
    """Return the log evidence of coefficients with products (k, k) and (k,) and a prior precision (k, k)."""
    root = np.linalg.inv(np.linalg.cholesky(prior))
    return float(log_evidence(root @ gram @ root.T, root @ score, 1.0))
