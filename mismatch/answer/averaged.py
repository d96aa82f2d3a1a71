"""A calibration whose numbers count as much as the recordings need them.

Where a drive hardly identifies a truck's numbers, those of `vehicle.toml` predict as well as a fit does. The
answer is the mean over how far numbers may be off, each weighed by its probability (Bayesian model averaging:
Hoeting, Madigan, Raftery and Volinsky, Statistical Science 1999).
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import softmax

from omnimate.mismatch.candidates.regression import slices_of
from omnimate.mismatch.evidence.density import log_evidence
from omnimate.mismatch.fit import held_of, prior_of

if TYPE_CHECKING:
    from omnimate.mismatch.fit import Acting, Fitted

# How far [declared sizes] numbers are off, standard deviations: those of a robot that is as described, to a
# third of a per mille, and, together as likely, of one that was never calibrated. Declared.
SIZES = np.array([0.03, 0.1, 0.3, 1.0])
SHARES = np.array([3.0, 1.0, 1.0, 1.0]) / 6.0


def averaged(fit: Fitted) -> Acting:
    """Return what is calibrated in addition to the findings, with the covariance of the mean over sizes."""
    acting = fit.calibrated
    if not acting.terms:
        return acting
    everything, first = list(fit.everything()), len(fit.chosen.terms)
    columns, data = fit.linear_model(fit.rows)
    gram, score = columns.T @ columns, columns.T @ data
    terms = [term for term, _, _ in everything]
    prior, held = prior_of(terms, first), held_of(terms)
    known = np.concatenate([values for _, _, values in everything])
    parts = slices_of(len(values) for _, _, values in everything)
    scales = np.ones((len(SIZES), len(gram)))
    for term, part in zip(terms[first:], parts[first:], strict=True):
        if not term.kind.is_setup:
            scales[:, part] = SIZES[:, None]
    inside = slice(parts[first].start, None)
    sizes, covariances, evidence = [], [], []
    for scale in scales:
        precision = prior / np.outer(scale, scale)
        root = np.linalg.inv(np.linalg.cholesky(precision))
        covariance = np.linalg.inv(gram + precision + held)
        sizes.append((known + covariance @ (score - (gram + precision) @ known))[inside])
        covariances.append(covariance[inside, inside])
        evidence.append(float(log_evidence(root @ gram @ root.T, root @ score, 1.0)))
    weights = softmax(np.log(SHARES) + evidence)
    mean = weights @ np.array(sizes)
    away = np.array(sizes) - mean
    covariance = np.einsum("s,sij->ij", weights, np.array(covariances)) + (weights * away.T) @ away
    values = tuple(mean[part] for part in slices_of(map(len, acting.values)))
    effects = tuple(term.built(coefficients) for term, coefficients in zip(acting.terms, values, strict=True))
    return replace(acting, values=values, effects=effects, covariance=covariance)
