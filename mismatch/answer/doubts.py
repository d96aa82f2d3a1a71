"""Reasons to doubt that the best name of the library is right: how sure an answer may be at most."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.answer.omnibus import leftover
from omnimate.mismatch.evidence.search import NAMELESS_MARGIN, overlap

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.mismatch.answer.omnibus import Leftover
    from omnimate.mismatch.candidates.terms import Term
    from omnimate.mismatch.investigate import Investigation
    from omnimate.vehicle.se2 import Array

SUREST = 0.999  # no probability above it is printed: the model itself is no surer
EVEN = 0.5  # probability of a name that is the best of wrong ones, at most
# Held-out residual from which no name is sure: a posterior predictive check (Gelman, Meng & Stern, Statistica
# Sinica 1996); what is 1.2 times the noise is 0.66 of it in addition.
MISFIT = 1.2


def surest_names(
    investigation: Investigation,
    parts: Sequence[Array],
    after: Array,
    explained: Sequence[float],
    left: Leftover,
    residual: float,
) -> list[float]:
    """Return the largest probability that each effect of the fit may have.

    A name is doubted where the fit does not explain the data; where what predicts the leftover, or the other
    laws, which are not exact, may explain as much; and on a component with a lasting error without a name, of
    which it may be a part. A push is doubted where events have a name: it may be one more of them. `parts`
    (V,) are what each effect explains of the data, `explained` their shares of the mismatch's square, `after`
    (V,) the data without all of them, and `residual` is the held-out residual.
    """
    terms = investigation.fit.chosen.terms
    nameless = {investigation.posterior.terms[member].component for member in _lasting(investigation)}
    has_named_events = any(term.is_local and not term.is_unknown for term in terms)
    predicted = _are_predicted(parts, after, left)
    inexact = _are_discrepancies(terms, explained)
    doubted = [
        has_named_events
        if term.is_unknown
        else residual >= MISFIT
        or predicted[number]
        or inexact[number]
        or (not term.is_local and term.component in nameless)
        for number, term in enumerate(terms)
    ]
    return [EVEN if doubt else SUREST for doubt in doubted]


def surest_unknown(investigation: Investigation) -> float:
    """Return the largest probability that a lasting error without a name may have.

    Its curves are judged as if noise were white: the omnibus test, which assumes nothing, must see it, too.
    """
    lasting = _lasting(investigation)
    if not lasting:
        return SUREST
    others = set(investigation.members) - lasting
    return min(SUREST, leftover(investigation.posterior, investigation.unknown, others).probability)


def _lasting(investigation: Investigation) -> set[int]:
    """Return the members that are lasting errors without a name."""
    terms = investigation.posterior.terms
    return {
        member for member in investigation.members if terms[member].is_unknown and not terms[member].is_event
    }


def _are_predicted(parts: Sequence[Array], after: Array, left: Leftover) -> list[bool]:
    """Say of each effect whether what predicts the leftover leaves it less than a margin of evidence.

    Effects explain `parts` (V,) of the data each, and leave `after` (V,).
    """
    if not left.predictions or not parts:
        return [False] * len(parts)
    columns = left.project_out(np.stack([after, *parts], axis=1))
    rest, parts_left = columns[:, 0], columns[:, 1:]
    squares, scores = (parts_left**2).sum(axis=0), parts_left.T @ rest
    return [bool(doubted) for doubted in (scores + squares) ** 2 < 2.0 * NAMELESS_MARGIN * squares]


def _are_discrepancies(terms: Sequence[Term], explained: Sequence[float]) -> list[bool]:
    """Say of each effect whether the others' laws, which are not exact, may leave as much as it explains.

    An event is compared with other events, as far as it acts when they do: lasting effects' discrepancies are
    noise to it when it is judged. Of the share that it explains, a law may miss the square of its declared
    discrepancy.
    """
    missed = [term.discrepancy**2 * max(share, 0.0) for term, share in zip(terms, explained, strict=True)]
    return [
        share
        < sum(missed[other] * _meets(term, terms[other]) for other in range(len(terms)) if other != number)
        for number, (term, share) in enumerate(zip(terms, explained, strict=True))
    ]


def _meets(term: Term, other: Term) -> float:
    """Return the share of a term's intervals in which another one acts, too; 1 where it always acts."""
    if not term.is_local:
        return 1.0
    meets = [overlap([interval], other.active_intervals) for interval in term.active_intervals]
    return sum(meets) / max(len(meets), 1)
