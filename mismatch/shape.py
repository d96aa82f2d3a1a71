"""Events as they are: no bump is a sharp edge under a stiff wheel, no patch is equally slippery throughout.

What an event's model leaves is a share of the event itself. A loosened term is the same effect with
columns for that share beside its own, so that what remains of a large bump is not taken for something else.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.choose import EVENTS, decoded
from omnimate.mismatch.leftover import windows_in_all
from omnimate.mismatch.moments import lasts, met, rolled
from omnimate.mismatch.scan import STEPPED
from omnimate.mismatch.signals import WINDOW
from omnimate.mismatch.surprise import LASTING, shoves
from omnimate.mismatch.terms import term
from omnimate.vcan_sim.crossing import losing
from omnimate.vcan_sim.effects.block import wheel_number
from omnimate.vcan_sim.effects.bump import BumpEvents

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from omnimate.mismatch.choose import Choice, Set
    from omnimate.mismatch.model import Columns
    from omnimate.mismatch.regression import Regression
    from omnimate.mismatch.surprise import Surprise
    from omnimate.mismatch.terms import Term
    from omnimate.mismatch.windows import Windows
    from omnimate.vcan_sim.effects.effect import Effect

UNEVEN = 0.4  # of what a patch takes in one stretch that it may be off by, one standard deviation
ROCKING = 0.15  # of an obstacle's height by which a truck that rolls over it rocks, likewise
SHOVED = 0.05  # likewise by which it comes to stand elsewhere than the way lost makes it
TURNED = 0.02  # likewise, seen from its middle, by which a wheel of it does
STEEP = 0.2  # of a wheel's radius: higher obstacles are not driven over
_CROSSING = 3  # windows that a crossing touches
_STRETCHES = 40  # of a patch, at most
BESIDE = 0.7  # [s] of a patch, within which bumps may be a part of it
BRIEF = 0.25  # [m] that a wheel rolls over a bump
_LEAST = 1e-4  # [m] of way lost
_BEFORE = 0.1  # [s] of an event's moment: a wheel touches before it climbs


def retold(regression: Regression, terms: Sequence[Term], chosen: Set) -> Iterator[tuple[str, list[Term]]]:
    """Yield wheels that have a patch, each with terms that tell of it and of the wheel's bumps more simply.

    What is slipperier in one place than in another is at first taken for a patch and for bumps beside it:
    one patch reaches over them, and the bumps elsewhere stay. A patch on a way as short as a bump may be one.
    A patch that does not begin, or does not end, within the drive may be a step of the wheel's radius.
    """
    tries = windows_in_all(regression)
    patches = {terms[one].component: terms[one] for one in chosen if terms[one].effect == "slip_patch"}
    bumps = {terms[one].component: terms[one] for one in chosen if terms[one].effect == "bump"}
    for wheel, patch in patches.items():
        for time in _only_edge(regression, patch):
            step = term("radius_step", wheel, STEPPED, time=time)
            if lasts(regression, step):
                yield wheel, [step, *([bumps[wheel]] if wheel in bumps else [])]
    for bump in [terms[one] for one in chosen if terms[one].effect == "bump"]:
        wheel, times = bump.component, bump.fixed["times"]
        if wheel not in patches:
            continue
        ((start, end),) = patches[wheel].fixed["intervals"]
        start = met(regression, wheel, start)
        near = [time for time in times if start - BESIDE < time < end + BESIDE]
        rest = tuple(time for time in times if time not in near)
        if near:
            hull = min(start, *near), max(end, *(time + BESIDE for time in near))
            patch = term("slip_patch", wheel, intervals=(hull,))
            patch = replace(patch, plausibility=patches[wheel].plausibility)
            yield wheel, [patch, *([term("bump", wheel, tries, times=rest)] if rest else [])]
        if rolled(regression, wheel, start, end) < BRIEF:
            yield wheel, [term("bump", wheel, tries, times=tuple(sorted({*times, start})))]


def _only_edge(regression: Regression, patch: Term) -> list[float]:
    """Return when a patch begins or ends [s], where it does only one of both while its wheel rolls."""
    ((start, end),) = patch.fixed["intervals"]
    before = rolled(regression, patch.component, -math.inf, start)
    after = rolled(regression, patch.component, end, math.inf)
    return [edge for edge, way in ((end, before), (start, after)) if way < BRIEF]


def loosened(regression: Regression, choice: Choice, chosen: Set) -> Iterator[Surprise]:
    """Yield the events of a set with free shapes, each with its columns for every recording."""
    for number, values, _ in decoded(choice, chosen):
        event = choice.terms[number]
        if event.effect not in EVENTS:
            continue
        place = choice.places[number]
        effect = event.built(values)
        columns: list[list[Columns]] = []
        for windows, (push, seen) in zip(regression.windows, regression.raw, strict=True):
            own = [(push[:, :, one], seen[:, :, one]) for one in range(place.start, place.stop)]
            shapes = _of_bumps if event.effect == "bump" else _of_patch
            columns.append([*own, *shapes(windows, effect)])
        yield event, columns


def _of_bumps(windows: Windows, effect: Effect) -> list[Columns]:
    """Return columns of what else a truck does while a wheel of its own rolls over each obstacle.

    It rocks forward, aside and back again, and is left a little off in all of its pose.
    """
    wheel = wheel_number(effect.component)
    truck, radius = wheel // 2, BumpEvents.radius(windows.signals.block, wheel)
    half = 0.5 * float(windows.signals.block.wheelbase[truck])
    values, still = effect.values(), np.zeros_like(windows.measured)
    columns: list[Columns] = []
    for time, lost in zip(values["times"], values["lost"], strict=True):
        edge = min(height(radius, max(lost, _LEAST)), STEEP * radius)
        pushes = shoves(windows, truck, np.array([edge, edge, edge / half]))[:, : windows.drift.shape[1]]
        inside = (windows.time > time - _BEFORE) & (windows.time < time + WINDOW + LASTING)
        if not windows.time[0] <= time <= windows.time[-1]:
            inside[:] = False  # of another recording: columns of nothing, so that all recordings have as many
        at = np.maximum(np.flatnonzero(inside)[:_CROSSING] - 1, 0)
        moved = np.zeros((_CROSSING, *windows.drift.shape, 3))
        moved[range(len(at)), at] = pushes[at]
        rocking = ROCKING * (moved[:-1] - moved[1:])[..., :2]
        shoved = SHOVED * moved[1:2, ..., :2]
        turned = TURNED * moved[..., 2:]
        for part in (*rocking, *shoved, *turned):
            columns += [(-part[..., one], still) for one in range(part.shape[-1])]
    return columns


def height(radius: float, lost: float) -> float:
    """Return the height [m] of an edge that takes some way from a wheel of a radius [m]."""
    return radius * (1.0 - math.cos(losing(radius, lost).half_angle))


def _of_patch(windows: Windows, effect: Effect) -> list[Columns]:
    """Return columns of a slip that is more or less than its mean, in stretches of each patch."""
    wheel, poses = wheel_number(effect.component), windows.drift.shape[1]
    still, columns = np.zeros_like(windows.measured), []
    way = effect.values()["fraction"] * windows.rolled[:, wheel]
    for start, end in effect.values()["intervals"]:
        stretch = np.floor((windows.time[1:] - start) / max((end - start) / _STRETCHES, WINDOW)).astype(int)
        inside = (windows.time[1:] > start) & (windows.time[:-1] < end)
        for number in range(round(min(_STRETCHES, (end - start) / WINDOW))):
            lost = np.where(inside & (stretch == number), UNEVEN * way, 0.0)
            columns.append((lost[:, None] * windows.lever[:, wheel, :poses], still))
    return columns
