"""Nonlinear parameters of effects: moments, intervals and thresholds, with their standard deviations."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimate.effects.block import wheel_number, wheel_radius

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.candidates.terms import Term
    from omnimate.mismatch.evidence.conditional_fit import ConditionalFit
    from omnimate.vehicle.se2 import Array

SHORTEST = 1.2  # [s] shortest interval, in which a robot travels about its length; shorter ones are bumps
_MAX_MOVES = 4  # at each step size
_BUMP_STEPS = 5  # steps by which a bump moves at once, at most: its evidence has several local maxima
MIN_STEP_TURNS = 10  # [1] turns of a wheel before and after a step of its radius: a patch of floor is shorter
_PRIOR_STEPS = 100.0  # prior standard deviation of a nonlinear parameter, in its finest steps
MOVABLE = ("times", "time", "above", "intervals")


def refine(regression: Regression, conditional: ConditionalFit, member: Term) -> Term:
    """Return a term of one column with moments, interval or threshold at the largest z score given a set."""
    z_score = _z_scores(regression, conditional, [member])[0]
    for step in _steps(regression, member):
        for _ in range(_MAX_MOVES):
            offers = [offer for offer in _moved(member, step) if lasts(regression, offer)]
            if not offers:
                break
            z_scores = _z_scores(regression, conditional, offers)
            at = int(np.argmax(z_scores))
            if z_scores[at] <= z_score + 1e-6:
                break
            member, z_score = offers[at], float(z_scores[at])
    return member


def _z_scores(regression: Regression, conditional: ConditionalFit, terms: Sequence[Term]) -> Array:
    """Return the z score of each term given a set, without its sign where either is possible."""
    z_scores = conditional.z_scores(regression.columns_of(terms))
    return z_scores if terms[0].positive else np.abs(z_scores)


def lasts(regression: Regression, member: Term) -> bool:
    """Say whether a wheel turns `MIN_STEP_TURNS` times before and after a step of its radius."""
    if member.kind.scan != "step":
        return True
    wheel, time = wheel_number(member.component), member.fixed["time"]
    blocks = [windows.signals.block for windows in regression.windows]
    total = sum(float(np.abs(block.travel[:, wheel]).sum()) for block in blocks)
    before = sum(float(np.abs(block.travel[block.time <= time, wheel]).sum()) for block in blocks)
    turn = 2.0 * math.pi * wheel_radius(blocks[0], wheel)
    return min(before, total - before) >= MIN_STEP_TURNS * turn


def _steps(regression: Regression, member: Term) -> tuple[float, ...]:
    """Return the steps of a term's nonlinear parameters, coarse to fine [s, m/s]."""
    sample = float(regression.windows[0].signals.recording.vehicle.bus.sync_period)
    if member.kind.scan == "moments":
        return 0.12, 0.04, sample
    if member.kind.scan == "threshold":
        return 0.05, 0.02, 0.005
    if member.kind.scan in {"step", "interval"}:
        return 4.0, 1.5, 0.5, 0.2, 0.06, sample
    return ()


def _moved(member: Term, step: float) -> list[Term]:
    """Return a term with its nonlinear parameters moved by a step to either side, or a bump by several."""
    moved: list[dict[str, Any]] = []
    if "times" in member.fixed:
        shifts = [number * step for number in range(-_BUMP_STEPS, _BUMP_STEPS + 1) if number]
        moved = [{"times": tuple(time + shift for time in member.fixed["times"])} for shift in shifts]
    for sign in (-step, step):
        if "time" in member.fixed:
            moved.append({"time": member.fixed["time"] + sign})
        elif "above" in member.fixed:
            moved.append({"above": max(0.01, member.fixed["above"] + sign)})
        elif "intervals" in member.fixed:
            start, end = member.fixed["intervals"][0]
            spans = (start + sign, end), (start, end + sign)
            moved += [{"intervals": (span,)} for span in spans if span[1] - span[0] >= SHORTEST]
    return [member.at(**fixed) for fixed in moved]


def spreads(regression: Regression, member: Term, values: Array) -> dict[str, tuple[float, ...]]:
    """Return standard deviations of a term's nonlinear parameters, by name, from the Fisher information."""
    step = min(_steps(regression, member), default=0.0)
    deviations: dict[str, tuple[float, ...]] = {}
    for name in MOVABLE:
        if step == 0.0 or name not in member.fixed:
            continue
        numbers = np.ravel(member.fixed[name]).astype(float)
        for at in range(len(numbers)):
            pair = [_replaced(member, name, numbers, at, sign * step) for sign in (-1.0, 1.0)]
            columns = regression.columns_of(pair)
            half = columns.shape[1] // 2
            slope = (columns[:, half:] - columns[:, :half]) @ values / (2.0 * step)
            information = float(slope @ slope) + (_PRIOR_STEPS * step) ** -2
            deviation = math.hypot(information**-0.5, step / math.sqrt(12.0))
            deviations[name] = (*deviations.get(name, ()), deviation)
    return deviations


def _replaced(member: Term, name: str, numbers: Array, at: int, step: float) -> Term:
    """Return a term with one value of a nonlinear parameter moved by a step."""
    moved = numbers.copy()
    moved[at] += step
    value: Any = float(moved[0]) if name in {"time", "above"} else tuple(moved.tolist())
    if name == "intervals":
        value = tuple(zip(value[0::2], value[1::2], strict=True))
    return member.at(**{name: value})
