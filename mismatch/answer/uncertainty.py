"""How sure the parameters of an effect are: what the data leave open, and how exact its law is."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.candidates.terms import angle_of

if TYPE_CHECKING:
    from omnimate.effects.effect import Effect
    from omnimate.mismatch.candidates.terms import Term
    from omnimate.vehicle.se2 import Array


def sigmas(member: Term, effect: Effect, covariance: Array) -> dict[str, float | tuple[float, ...]]:
    """Return the standard deviations of the parameters that a term's coefficients tell.

    Args:
        member: the term.
        effect: that was built of it.
        covariance: (k, k) of its coefficients.
    """
    if member.is_setup:
        own = effect.parameters
        told = np.sqrt(np.diag(covariance)).tolist()
        return {one.name: one.scale * sigma for one, sigma in zip(own, told, strict=True)}
    spec = next(one for one in effect.parameters if one.name == member.linear)
    value = getattr(effect, member.linear)
    inexact = effect.discrepancy()
    angle_name = angle_of(type(effect))
    if angle_name is not None:
        size, angle = max(value / spec.scale, 1e-9), getattr(effect, angle_name)
        along = np.array([math.cos(angle), math.sin(angle)])
        across = np.array([-math.sin(angle), math.cos(angle)])
        size_told = spec.scale * math.sqrt(float(along @ covariance @ along))
        turned = math.sqrt(float(across @ covariance @ across)) / size
        return {
            member.linear: math.hypot(size_told, inexact * value),
            angle_name: min(math.hypot(turned, inexact), math.pi),
        }
    deviations = spec.scale * np.sqrt(np.diag(covariance))
    if member.is_event:
        return {member.linear: tuple(np.hypot(deviations, inexact * np.asarray(value)).tolist())}
    return {member.linear: math.hypot(float(deviations[0]), inexact * (value - (spec.null or 0.0)))}
