"""The search for what a simulation leaves out of recordings: noise, candidates, proposals, in turns."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.bank import add_bank
from omnimate.mismatch.choose import EMPTY, EVENTS, Choice, decoded, tolerant
from omnimate.mismatch.leftover import leftover, windows_in_all
from omnimate.mismatch.moments import firm, settle
from omnimate.mismatch.noise import DEFAULT_LEVELS, estimate_noise
from omnimate.mismatch.outliers import freed
from omnimate.mismatch.regression import Regression
from omnimate.mismatch.scan import merged, proposals
from omnimate.mismatch.shape import loosened, retold
from omnimate.mismatch.signals import WINDOW
from omnimate.mismatch.surprise import surprises
from omnimate.mismatch.terms import skews, smooth_terms
from omnimate.mismatch.windows import windows_of
from omnimate.vcan_sim.effects.castor_kick import CastorKick

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from numpy.typing import NDArray

    from omnimate.mismatch.choose import Set
    from omnimate.mismatch.noise import NoiseLevels
    from omnimate.mismatch.terms import Term
    from omnimate.mismatch.windows import Windows
    from omnimate.vcan_sim.effects.effect import Effect
    from omnimate.vehicle.se2 import Array

    Progress = Callable[[int, int, str], None]

ROUNDS = 4  # of proposals; a recording with one bump under each wheel needs as many
# Effects that stand for what may be wrong with any robot, while nothing is chosen yet.
_USUAL = {"wheel_diameter", "wheelbase", "joint_bias", "link_bias", "wheel_eccentricity", "latency"}
_OUTSIDE = {
    "floor_slope"
}  # likewise, where poses are measured: what takes both trucks alike shows there only
COARSE = 0.03  # [s] to which moments are settled while the search goes on
_FEW = 0.005  # of all windows: so many stand out by chance
_TURNS = 5  # of estimating the noise, each without what stands out of the last one
STEPS = 10  # that a progress bar sees


@dataclass(slots=True)
class Investigation:
    """What the search came to.

    Attributes:
        regression: the whitened recordings, with the columns of all candidates.
        choice: the candidates and the sets of them that were compared.
        chosen: the best set.
        skew: columns of what the linkage's encoders are out of step with the wheels', in any robot.
    """

    regression: Regression
    choice: Choice
    chosen: Set
    skew: slice

    def untolerant(self) -> Choice:
        """Return the candidates without what every robot has a little of: sets explain all that they can."""
        return Choice(self.choice.terms, self.choice.places, self.regression.total)

    def members(self) -> list[Term]:
        """Return the terms of the best set, in order."""
        return [self.choice.terms[one] for one in sorted(self.chosen)]


def investigate(
    windows: Sequence[Windows],
    folds: Sequence[NDArray[np.int64]],
    *,
    without: Iterable[str] = (),
    base: Sequence[Effect] = (),
    noise: NoiseLevels = DEFAULT_LEVELS,
    progress: Progress = lambda _done, _all, _doing: None,
) -> Investigation:
    """Return the set of effects that explains recordings best.

    Args:
        windows: of each recording.
        folds: of each recording, as `folds_of` gives them.
        without: effects to leave out of the library.
        base: effects about which the model is linear.
        noise: levels from which to estimate them.
        progress: is told how much is done, of how much, and what is being done.
    """
    left_out = set(without)
    progress(0, STEPS, "signatures of all effects")
    terms = [one for one in smooth_terms([own.signals for own in windows]) if one.effect not in left_out]
    regression = Regression(windows, noise, base, folds)
    skewed = regression.add([one for one in skews(windows[0].signals) if one.effect not in left_out])
    skew = slice(1, 1 + len(skewed))
    places = regression.add(terms)
    progress(2, STEPS, "noise levels")
    seen = any(one.signals.poses is not None for one in windows)
    ordinary = _USUAL | (_OUTSIDE if seen else set())
    usual = frozenset(at for at, one in enumerate(terms) if one.effect in ordinary)
    _estimate(regression, terms, places, usual, _TURNS)
    choice = Choice(terms, places, tolerated(regression, terms, places, skew))
    progress(4, STEPS, "comparing sets of effects")
    chosen = choice.best(EMPTY)
    for turn in range(ROUNDS):
        progress(5 + turn, STEPS, "looking for events")
        proposed = proposals(regression, choice, chosen)
        new = [one for one in merged(terms, proposed) if one.effect not in left_out]
        places += regression.add(new)
        terms += new
        before = _told(terms, chosen)
        choice = Choice(terms, places, tolerated(regression, terms, places, skew))
        chosen = choice.best(chosen)
        _swing(regression, choice, chosen)
        settled = firm(regression, settle(regression, [terms[one] for one in sorted(chosen)], COARSE))
        moved = merged(terms, settled)
        places += regression.add(moved)
        terms += moved
        chosen = frozenset(number for number, one in enumerate(terms) if any(one is own for own in moved)) | {
            one for one in chosen if terms[one].key not in {own.key for own in moved}
        }
        _estimate(regression, terms, places, chosen)
        choice = Choice(terms, places, tolerated(regression, terms, places, skew))
        chosen = choice.best(chosen)
        if turn > 0 and (not new or _told(terms, chosen) == before):
            break
    progress(9, STEPS, "what no effect explains")
    if "unknown" not in left_out:
        choice, chosen = _against_the_unknown(regression, terms, places, chosen, skew)
    return Investigation(regression, choice, chosen, skew)


def _swing(regression: Regression, choice: Choice, chosen: Set) -> None:
    """Let the trucks that a set has castors kick swing as they like at each reversal, and no other."""
    fitted = decoded(choice, chosen)
    built = [choice.terms[one].built(own) for one, own, _ in fitted if choice.terms[one].probes]
    kicks = [one for one in built if isinstance(one, CastorKick)]
    if kicks or any(one.kicks for one in regression.windows):
        regression.windows = [windows_of(one.signals, kicks=kicks) for one in regression.windows]


def _told(terms: Sequence[Term], chosen: Set) -> set[tuple[str, str, int]]:
    """Return the effects of a set, and how many events each has."""
    return {(*terms[one].key, len(terms[one].probes)) for one in chosen}


def _against_the_unknown(
    regression: Regression, terms: list[Term], places: list[slice], chosen: Set, skew: slice
) -> tuple[Choice, Set]:
    """Let what was chosen stand against what no effect explains, and against its own events as they are."""
    bank, at = add_bank(regression)
    terms, places = [*terms, *bank], [*places, *at]
    starts = [chosen]
    for wheel, simpler in retold(regression, terms, chosen):
        others = [one for one in sorted(chosen) if terms[one].key not in {(event, wheel) for event in EVENTS}]
        settled = settle(regression, [*(terms[one] for one in others), *simpler], COARSE)[len(others) :]
        starts.append(frozenset({*others, *range(len(terms), len(terms) + len(settled))}))
        places += regression.add(settled)
        terms += settled
    choice = Choice(terms, places, tolerated(regression, terms, places, skew))
    left, members = leftover(regression, choice, chosen), [terms[one] for one in sorted(chosen)]
    more = list(surprises(regression, left, members))
    for start in starts:
        more += loosened(regression, choice, start)
    places = [*places, *(regression.extend(columns) for _, columns in more)]
    terms = [*terms, *(term for term, _ in more)]
    choice = Choice(terms, places, tolerated(regression, terms, places, skew))
    return choice, max((choice.best(start) for start in starts), key=choice.worth)


def tolerated(regression: Regression, terms: Sequence[Term], places: Sequence[slice], skew: slice) -> Array:
    """Return the products of all columns, with what every robot has a little of integrated out.

    An obstacle that many terms hold is tolerated once.
    """
    sizes = np.zeros(regression.white.shape[1])
    sizes[skew] = 1.0
    known: set[tuple[str, int]] = set()
    for term, place in zip(terms, places, strict=True):
        if place.stop - place.start != len(term.probes):
            continue  # unknown, or loosened
        sizes[place] = term.tolerance
        for column, time in enumerate(term.fixed.get("times", ()), place.start):
            obstacle = term.component, round(time / WINDOW)
            sizes[column] *= obstacle not in known
            known.add(obstacle)
    return tolerant(regression.total, sizes)


def _estimate(
    regression: Regression, terms: list[Term], places: list[slice], nuisances: Set, turns: int = 1
) -> None:
    """Estimate the noise with some terms as nuisances, and whiten with it.

    In several turns, what stands out of the noise known so far does not count: of an ordinary robot's first,
    lest a long patch or a dozen obstacles make the floor look rough, and be lost in it.
    """
    columns = [0, *(column for one in nuisances for column in range(places[one].start, places[one].stop))]
    picked = [(push[:, :, columns], seen[:, :, columns]) for push, seen in regression.raw]
    windows, happened = regression.windows, math.inf
    for _ in range(turns):
        if turns > 1:
            left = leftover(regression, Choice(terms, places, regression.total), nuisances)
            windows, count = freed(regression, left)
            if abs(count - happened) <= _FEW * windows_in_all(regression):
                return
            happened = count
        regression.whiten(estimate_noise(windows, picked, regression.noise))
