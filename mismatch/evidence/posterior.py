"""How likely sets of candidates are, and what is left beside them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.evidence.beside import NOTHING, Beside
from omnimate.mismatch.evidence.density import LARGEST, log_evidence
from omnimate.mismatch.evidence.rows import products_by_group

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.candidates.terms import Term
    from omnimate.mismatch.evidence.candidates import Candidates
    from omnimate.vehicle.se2 import Array

_READY = 6  # sets of which all columns are kept


@dataclass(slots=True)
class Posterior:
    """Sets of candidates, and what is known of each.

    Attributes:
        candidates: The candidates, and the recordings that judge them.
        known: What is left beside sets; the one that was asked last is the last.
    """

    candidates: Candidates
    known: dict[frozenset[int], Beside] = field(default_factory=dict)

    @property
    def regression(self) -> Regression:
        """The recordings, with the columns of all candidates."""
        return self.candidates.regression

    @property
    def terms(self) -> list[Term]:
        """The candidates."""
        return self.candidates.terms

    @property
    def places(self) -> list[slice]:
        """Where each candidate's columns are."""
        return self.candidates.places

    def with_more(self, terms: Sequence[Term], places: Sequence[slice]) -> Posterior:
        """Return the same with more candidates, whose columns are in some places."""
        every, where = [*self.terms, *terms], [*self.places, *places]
        return Posterior(replace(self.candidates, terms=every, places=where))

    def beside(self, members: Iterable[int]) -> Beside:
        """Return what is left beside a set."""
        key = frozenset(members)
        beside = self.known.pop(key, None) or Beside(self.candidates, tuple(sorted(key)))
        self.known[key] = beside
        for old in list(self.known.values())[-_READY - 1 : -_READY]:
            old.release()
        return beside

    def evidence(self, members: Iterable[int]) -> float:
        """Return the log posterior odds of a set against none of it, with every law exact."""
        chosen = sorted(members)
        if not chosen:
            return 0.0
        beside = self.beside(())
        gram, score = beside.products(chosen)
        odds = sum(self.candidates.odds(single, chosen[:number]) for number, single in enumerate(chosen))
        everyday = beside.everyday({self.terms[single].key for single in chosen})
        return float(log_evidence(gram, score, LARGEST)) - everyday + odds

    def redrawn(self, members: Iterable[int], draws: Array) -> Array:
        """Return by how much likelier a set is against none of it, (n,), with stretches drawn anew.

        Args:
            members: The set.
            draws: How often each stretch is drawn, `(n, stretches)`.
        """
        columns = [at for single in sorted(members) for at in self.candidates.columns(single)]
        if not columns:
            return np.zeros(len(draws))
        beside = self.beside(())
        gram, score = products_by_group(self.candidates.stretch, beside.columns(columns), beside.residual)
        drawn = log_evidence(np.tensordot(draws, gram, 1), draws @ score, LARGEST)
        return drawn - log_evidence(gram.sum(axis=0), score.sum(axis=0), LARGEST)

    def bar(self, candidates: Iterable[int]) -> None:
        """Let candidates be none any more."""
        for single in candidates:
            self.terms[single] = replace(self.terms[single], odds=NOTHING)
        self.known.clear()
