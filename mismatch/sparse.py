"""Plain ways to choose among terms: thresholded least squares, the lasso, and the best one alone.

They know the products of columns whose noise is white and no more. Each offers sets of terms along its
own path; the extended Bayesian information criterion (Chen and Chen, Biometrika 2008) takes one of them.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.choose import EMPTY, decoded

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from omnimate.mismatch.choose import Choice, Set
    from omnimate.vehicle.se2 import Array

    Method = Callable[[Choice], Iterable[Set]]

THRESHOLDS = np.geomspace(0.02, 3.0, 25)  # of coefficients, in a-priori standard deviations
PENALTIES = np.geomspace(1.0, 3e-3, 30)  # of the lasso, as a share of the least that leaves nothing
SWEEPS = 60  # of coordinate descent for each penalty
NOTHING = ("", "")  # in a member's place
MOST = 16  # terms in a set, from which on a path is left


def stlsq(choice: Choice) -> Iterator[Set]:
    """Yield the sets of sequentially thresholded least squares (Brunton, Proctor, Kutz, PNAS 2016).

    The coefficients of all terms are fitted with a ridge, those below a threshold are dropped, and the
    rest are fitted again until none is; once for each threshold.
    """
    for threshold in THRESHOLDS:
        members, before = frozenset(range(len(choice.terms))), EMPTY
        while members not in {before, EMPTY}:
            before = members
            members = frozenset(
                one for one, own, _ in decoded(choice, members) if math.hypot(*own) >= threshold
            )
        yield members


def lasso(choice: Choice) -> Iterator[Set]:
    """Yield the sets of terms along the lasso's path (Tibshirani, JRSS B 1996), by coordinate descent."""
    columns = choice.columns(range(len(choice.terms)))
    size = np.sqrt(np.maximum(choice.total[columns, columns], 1e-12))
    gram = choice.total[np.ix_(columns, columns)] / (size * size[:, None])
    own = choice.total[columns, 0] / size
    owner = np.concatenate([[one] * len(choice.columns([one])) for one in range(len(choice.terms))])
    values = np.zeros(len(columns))
    for penalty in PENALTIES * np.abs(own).max():
        descend(gram, own, float(penalty), values)
        members = frozenset(owner[values != 0.0].tolist())
        if len(members) > MOST:
            return
        yield members


def descend(gram: Array, own: Array, penalty: float, values: Array) -> None:
    """Minimise b'A b / 2 - own'b + penalty |b| from values `(C,)` on, in place.

    Args:
        gram: A (C, C), of columns of unit length.
        own: (C,) products of the columns with the data.
        penalty: of the coefficients' absolute values.
        values: b.
    """
    for _ in range(SWEEPS):
        moved = 0.0
        for column in range(len(own)):
            free = own[column] - gram[column] @ values + gram[column, column] * values[column]
            new = math.copysign(max(abs(free) - penalty, 0.0), free)
            moved = max(moved, abs(new - values[column]))
            values[column] = new
        if moved < 1e-4 * penalty:
            return


def single(choice: Choice) -> Iterator[Set]:
    """Yield every term alone."""
    return (frozenset({one}) for one in range(len(choice.terms)))


METHODS: dict[str, Method] = {"STLSQ": stlsq, "lasso": lasso, "single cause": single}


def sensible(choice: Choice, members: Set) -> Set:
    """Return a set without coefficients that make no sense, and with each effect and component once."""
    fitted = decoded(choice, members)
    bad = {one for one, own, _ in fitted if choice.terms[one].positive and np.any(own < 0.0)}
    if bad:
        return sensible(choice, members - bad)
    strongest = {
        choice.terms[one].key: one
        for one, _, _ in sorted(fitted, key=lambda item: _explained(choice, item[0], item[1]))
    }
    once = frozenset(strongest.values())
    return members if once == members else sensible(choice, once)


def _explained(choice: Choice, one: int, coefficients: Array) -> float:
    columns = choice.columns([one])
    return float(coefficients @ choice.total[np.ix_(columns, columns)] @ coefficients)


def left(choice: Choice, members: Set) -> float:
    """Return the sum of squares that a set leaves."""
    return float(choice.total[0, 0]) - choice.explained(members)


def criterion(choice: Choice, members: Set, rows: int) -> float:
    """Return the extended Bayesian information criterion of a set, fitted to rows of data.

    What its terms are likelier a priori than others counts, too: an event was looked for at many moments.
    """
    names = len({term.key for term in choice.terms})
    likelier = sum(choice.terms[one].plausibility for one in members) - math.log(
        math.comb(names, len(members))
    )
    cost = len(choice.columns(members)) * math.log(rows) - 2.0 * likelier
    return rows * math.log(left(choice, members) / rows) + cost


def chosen(choice: Choice, method: Method, rows: int) -> Set:
    """Return the best of the sets that a method offers, or the empty one."""
    offers = {EMPTY, *(sensible(choice, members) for members in method(choice))}
    return min(offers, key=lambda members: criterion(choice, members, rows))


def weights(choice: Choice, members: Set, one: int, rows: int) -> dict[tuple[str, str], float]:
    """Return the Schwarz weights of a member, of every other term in its place, and of nothing."""
    rest = members - {one}
    offers = [rest | {other} for other in range(len(choice.terms)) if other not in rest]
    keys = {rest: NOTHING} | {offer: choice.terms[next(iter(offer - rest))].key for offer in offers}
    values = {offer: criterion(choice, offer, rows) for offer in keys if sensible(choice, offer) == offer}
    least = min(values.values())
    found: dict[tuple[str, str], float] = {}
    for offer, value in values.items():
        found[keys[offer]] = found.get(keys[offer], 0.0) + math.exp(0.5 * (least - value))
    whole = sum(found.values())
    return {key: weight / whole for key, weight in found.items()}
