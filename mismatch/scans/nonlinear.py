"""What is not linear in an effect: its moments, stretches of time and thresholds, and how sure they are."""

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

SHORTEST = 1.2  # [s] of a stretch: a robot's length at its pace; what is shorter is a bump
_PATIENCE = 4  # moves in one direction
_REACH = 5  # steps of a bump at once: its evidence has several hills
_OFTEN = 10  # turns of a wheel before and after a step of its radius: a patch of the floor is shorter
_WIDE = 100.0  # steps by which a moment may be off at most
MOVABLE = ("times", "time", "above", "intervals")


def refine(regression: Regression, conditional: ConditionalFit, member: Term) -> Term:
    """Return a term with its moments, interval or threshold where it is seen best beside a set.

    Args:
        regression: To whose recordings it is to fit.
        conditional: Fit given the other members.
        member: A term of one column.
    """
    height = _height(regression, conditional, [member])[0]
    for step in _steps(regression, member):
        for _ in range(_PATIENCE):
            offers = [offer for offer in _moved(member, step) if lasts(regression, offer)]
            if not offers:
                break
            heights = _height(regression, conditional, offers)
            at = int(np.argmax(heights))
            if heights[at] <= height + 1e-6:
                break
            member, height = offers[at], float(heights[at])
    return member


def _height(
    regression: Regression, conditional: ConditionalFit, terms: Sequence[Term]
) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return by how many sigma each term is seen."""
    sigmas = conditional.z_scores(regression.columns_of(terms))
    return sigmas if terms[0].positive else np.abs(sigmas)


def rolled(regression: Regression, wheel: str, start: float, end: float) -> float:
    """Return the way [m] that a wheel rolls between two times [s], whatever its direction."""
    way = 0.0
    for windows in regression.windows:
        block = windows.signals.block
        inside = (block.time > start) & (block.time <= end)
        way += float(np.abs(block.travel[inside, wheel_number(wheel)]).sum())
    return way


def lasts(regression: Regression, member: Term) -> bool:
    """Say whether a wheel turns often before and after a step of its radius, which a patch would be else."""
    if member.scan != "step":
        return True
    wheel, time = member.component, member.fixed["time"]
    radius = wheel_radius(regression.windows[0].signals.block, wheel_number(wheel))
    ways = rolled(regression, wheel, -math.inf, time), rolled(regression, wheel, time, math.inf)
    return min(ways) >= 2.0 * math.pi * radius * _OFTEN


def _steps(regression: Regression, member: Term) -> tuple[float, ...]:
    """Return by how much to move what is not linear, coarse to fine [s, m/s]."""
    sample = float(regression.windows[0].signals.recording.vehicle.bus.sync_period)
    if member.scan == "moments":
        return 0.12, 0.04, sample
    if member.scan == "threshold":
        return 0.05, 0.02, 0.005
    if member.scan in {"step", "interval"}:
        return 4.0, 1.5, 0.5, 0.2, 0.06, sample
    return ()


def _moved(member: Term, step: float) -> list[Term]:
    """Return a term with what is not linear moved by a step to either side, or a bump by several."""
    found: list[dict[str, Any]] = []
    if "times" in member.fixed:
        shifts = [number * step for number in range(-_REACH, _REACH + 1) if number]
        found = [{"times": tuple(time + shift for time in member.fixed["times"])} for shift in shifts]
    for sign in (-step, step):
        if "time" in member.fixed:
            found.append({"time": member.fixed["time"] + sign})
        elif "above" in member.fixed:
            found.append({"above": max(0.01, member.fixed["above"] + sign)})
        elif "intervals" in member.fixed:
            start, end = member.fixed["intervals"][0]
            spans = (start + sign, end), (start, end + sign)
            found += [{"intervals": (span,)} for span in spans if span[1] - span[0] >= SHORTEST]
    return [member.at(**fixed) for fixed in found]


def spreads(
    regression: Regression, member: Term, values: np.ndarray[Any, np.dtype[np.float64]]
) -> dict[str, tuple[float, ...]]:
    """Return the standard deviations of what is not linear in a term, by name: of the Fisher information.

    Args:
        regression: About the effects that fit best.
        member: A term of them.
        values: Its coefficients, `(k,)`.
    """
    step = min(_steps(regression, member), default=0.0)
    found: dict[str, tuple[float, ...]] = {}
    for name in MOVABLE:
        if step == 0.0 or name not in member.fixed:
            continue
        numbers = np.ravel(member.fixed[name]).astype(float)
        for at in range(len(numbers)):
            pair = [_replaced(member, name, numbers, at, sign * step) for sign in (-1.0, 1.0)]
            columns = regression.columns_of(pair)
            half = columns.shape[1] // 2
            slope = (columns[:, half:] - columns[:, :half]) @ values / (2.0 * step)
            told = float(slope @ slope) + (_WIDE * step) ** -2
            found[name] = (*found.get(name, ()), math.hypot(told**-0.5, step / math.sqrt(12.0)))
    return found


def _replaced(
    member: Term, name: str, numbers: np.ndarray[Any, np.dtype[np.float64]], at: int, step: float
) -> Term:
    """Return a term with one of its numbers moved by a step."""
    moved = numbers.copy()
    moved[at] += step
    value: Any = float(moved[0]) if name in {"time", "above"} else tuple(moved.tolist())
    if name == "intervals":
        value = tuple(zip(value[0::2], value[1::2], strict=True))
    return member.at(**{name: value})
