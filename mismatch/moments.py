"""What is not linear in an effect: its moments, stretches of time and thresholds, and how sure they are."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimate.mismatch.choose import Choice, decoded
from omnimate.mismatch.leftover import windows_in_all
from omnimate.mismatch.terms import Term, term
from omnimate.vcan_sim.effects.block import wheel_number
from omnimate.vcan_sim.effects.bump import BumpEvents

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from omnimate.mismatch.regression import Regression

_PATIENCE = 12  # moves in one direction
_REACH = 5  # steps of a bump at once: its evidence has several hills
_WIDE = 100.0  # steps by which a moment may be off at most
_SAME = 0.1  # [s] between moments of one bump
_OFTEN = 10  # turns of a wheel
_FAINT = 2.5  # sigma of a bump's size, below which it is left out
Loose = dict[str, tuple[float, ...]]  # standard deviations of numbers, by name


def events_of(member: Term) -> list[float]:
    """Return the moments [s] at which something happens in a term."""
    if "times" in member.fixed:
        return list(member.fixed["times"])
    if "time" in member.fixed:
        return [member.fixed["time"]]
    return [edge for interval in member.fixed.get("intervals", ()) for edge in interval]


def settle(regression: Regression, members: Sequence[Term], finest: float = 0.0) -> list[Term]:
    """Return members with moments, intervals and thresholds where they fit best, one after the other.

    Args:
        regression: to whose recordings they are to fit; it is left as it was.
        members: of a set of terms.
        finest: step below which to stop.
    """
    split = [part for member in members for part in _parts(member)]
    bare = regression.bare()
    places = bare.add(split)
    for number in range(len(split)):
        for step in _steps(regression, split[number]):
            for _ in range(_PATIENCE if step >= finest else 0):
                offers = [one for one in _moved(split[number], step) if lasts(regression, one)]
                best = _better(bare, split, places, number, offers)
                if best is None:
                    break
                split[number] = best
    settled = []
    for member in members:
        own = [one for one in split if one.key == member.key]
        if member.effect == "bump":
            times = _distinct([met(regression, member.component, one.fixed["times"][0]) for one in own])
            settled.append(term("bump", member.component, windows_in_all(regression), times=times))
        else:
            settled.append(replace(own[0], plausibility=member.plausibility))
    return settled


def met(regression: Regression, wheel: str, time: float) -> float:
    """Return when a wheel meets what it came to at a time [s]: one that stands meets it when it rolls on."""
    for windows in regression.windows:
        block = windows.signals.block
        begins = block.time - block.period
        if begins[0] <= time <= block.time[-1]:
            rolls = np.flatnonzero((block.travel[:, wheel_number(wheel)] != 0.0) & (block.time > time))
            return max(time, float(begins[rolls[0]])) if len(rolls) else time
    return time


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
    if member.effect != "radius_step":
        return True
    wheel, time = member.component, member.fixed["time"]
    radius = BumpEvents.radius(regression.windows[0].signals.block, wheel_number(wheel))
    ways = rolled(regression, wheel, -math.inf, time), rolled(regression, wheel, time, math.inf)
    return min(ways) >= 2.0 * math.pi * radius * _OFTEN


def _distinct(times: Sequence[float]) -> tuple[float, ...]:
    """Return moments [s] in order, without those that came to the same bump as another."""
    found: list[float] = []
    for time in sorted(times):
        if not found or time - found[-1] > _SAME:
            found.append(time)
    return tuple(found)


def _parts(member: Term) -> list[Term]:
    """Return a term for each of a member's bumps, or the member."""
    if member.effect != "bump":
        return [member]
    return [term("bump", member.component, times=(time,)) for time in member.fixed["times"]]


def _better(
    regression: Regression,
    terms: Sequence[Term],
    places: Sequence[slice],
    number: int,
    offers: Sequence[Term],
) -> Term | None:
    """Return the offer that beats a term in its set, its columns in the term's place, or None.

    The other terms may have sizes below zero, which make no sense: they are not where they belong yet.
    """
    if not offers:
        return None
    columns = regression.add(offers)
    others = [replace(one, positive=one.positive and at == number) for at, one in enumerate(terms)]
    choice = Choice([*others, *offers], [*places, *columns], regression.total, repeats=True)
    chosen = frozenset(range(len(terms)))
    worths = [choice.worth(chosen - {number} | {len(terms) + at}) for at in range(len(offers))]
    at = int(np.argmax(worths))
    better = worths[at] > choice.worth(chosen) + 1e-6
    if better:
        regression.replace(places[number], columns[at])
    regression.drop(columns[0].start)
    return offers[at] if better else None


def _steps(regression: Regression, member: Term) -> tuple[float, ...]:
    """Return by how much to move what is not linear, coarse to fine [s, m/s]."""
    sample = float(regression.windows[0].signals.recording.vehicle.bus.sync_period)
    if member.effect == "bump":
        return 0.12, 0.04, sample
    if member.effect == "count_loss":
        return 0.05, 0.02, 0.005
    if member.effect in {"radius_step", "slip_patch"}:
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
            found += [{"intervals": (span,)} for span in spans if span[0] < span[1]]
    return [term(member.effect, member.component, **fixed) for fixed in found]


def firm(regression: Regression, members: Sequence[Term]) -> list[Term]:
    """Return members without the bumps that are too faint to be told of.

    Args:
        regression: that says how large they are; it is left as it was.
        members: of a set of terms.
    """
    if not members:
        return []
    bare = regression.bare()
    places = bare.add(members)
    kept = list(members)
    for number, values, covariance in decoded(Choice(kept, places, bare.total), range(len(kept))):
        if kept[number].effect == "bump":
            there = values > _FAINT * np.sqrt(np.diag(covariance))
            times = tuple(np.asarray(kept[number].fixed["times"])[there].tolist())
            if 0 < len(times) < len(there):
                kept[number] = term("bump", kept[number].component, windows_in_all(regression), times=times)
    return kept


def looseness(regression: Regression, members: Sequence[Term]) -> list[Loose]:
    """Return the standard deviations of what is not linear in terms, by name: of the Fisher information.

    Args:
        regression: to which the terms fit best; it is left as it was.
        members: terms, all of which are there.
    """
    if not members:
        return []
    regression = regression.bare()
    places = regression.add(members)
    columns = slice(places[0].start, places[-1].stop)
    found: list[Loose] = [{} for _ in members]
    slopes, owners = [], []
    for number, values, _ in decoded(Choice(list(members), places, regression.total), range(len(members))):
        step = min(_steps(regression, members[number]), default=0.0)
        for name, before, after in _shifted(members[number], step) if step else ():
            either = regression.add([before, after])
            first, second = (regression.white[:, one] @ values for one in either)
            slopes.append((second - first) / (2.0 * step))
            owners.append((number, name, step))
            regression.drop(either[0].start)
    if slopes:
        own = regression.white[:, columns]
        across = np.stack(slopes, axis=1)
        shared = own.T @ across
        precision = own.T @ own + np.eye(own.shape[1])
        told = across.T @ across - shared.T @ np.linalg.solve(precision, shared)
        widest = np.array([(_WIDE * sample) ** -2 for _, _, sample in owners])
        spread = np.sqrt(np.diag(np.linalg.inv(told + np.diag(widest))))
        for (number, name, sample), sigma in zip(owners, spread, strict=True):
            rounded = math.hypot(float(sigma), sample / math.sqrt(12.0))
            found[number][name] = (*found[number].get(name, ()), rounded)
    return found


def _shifted(member: Term, step: float) -> Iterator[tuple[str, Term, Term]]:
    """Yield for every number that is not linear its name, and the term with it a step less and more."""
    for name in ("times", "time", "above", "intervals"):
        if name not in member.fixed:
            continue
        numbers = np.ravel(member.fixed[name])
        for at in range(len(numbers)):
            pair = []
            for sign in (-step, step):
                moved = numbers.copy()
                moved[at] += sign
                value: Any = moved.tolist()[0] if name in {"time", "above"} else tuple(moved.tolist())
                if name == "intervals":
                    value = tuple(zip(value[0::2], value[1::2], strict=True))
                pair.append(term(member.effect, member.component, **{**member.fixed, name: value}))
            yield name, pair[0], pair[1]
