"""Posterior odds of sets of candidates, and the fits conditional on them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from omnimate.mismatch.evidence.conditional_fit import IMPOSSIBLE, ConditionalFit
from omnimate.mismatch.evidence.density import MEMBER_SIZE, log_evidence
from omnimate.mismatch.evidence.rows import products_by_group

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from omnimate.mismatch.candidates.regression import Regression
    from omnimate.mismatch.candidates.terms import Term
    from omnimate.mismatch.evidence.candidates import Candidates
    from omnimate.vehicle.se2 import Array

_CACHED_FITS = 6  # sets whose arrays are kept in memory


@dataclass(slots=True)
class Posterior:
    """Posterior over sets of candidates."""

    candidates: Candidates  # the candidates, and the recordings that judge them
    # cached fits given sets; the one that was asked for last is the last
    fits: dict[frozenset[int], ConditionalFit] = field(default_factory=dict)

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
        """Return the posterior with more candidates, whose columns are in some places."""
        all_terms, all_places = [*self.terms, *terms], [*self.places, *places]
        return Posterior(replace(self.candidates, terms=all_terms, places=all_places))

    def given(self, members: Iterable[int]) -> ConditionalFit:
        """Return the data and candidates given a set."""
        key = frozenset(members)
        fit = self.fits.pop(key, None) or ConditionalFit(self.candidates, tuple(sorted(key)))
        self.fits[key] = fit
        for old in list(self.fits.values())[-_CACHED_FITS - 1 : -_CACHED_FITS]:
            old.release()
        return fit

    def evidence(self, members: Iterable[int]) -> float:
        """Return the log posterior odds of a set against the empty one, if every law is exact."""
        chosen = sorted(members)
        if not chosen:
            return 0.0
        conditional = self.given(())
        gram, score = conditional.products_without_background(chosen)
        odds = sum(
            self.candidates.odds(candidate, chosen[:number]) for number, candidate in enumerate(chosen)
        )
        background = conditional.background_log_bayes_factor(
            {self.terms[candidate].key for candidate in chosen}
        )
        return float(log_evidence(gram, score, MEMBER_SIZE)) - background + odds

    def bootstrap_gain(self, members: Iterable[int], draws: Array) -> Array:
        """Return changes (n,) of a set's log evidence with stretches drawn so often, `(n, stretches)`."""
        columns = [column for candidate in sorted(members) for column in self.candidates.columns(candidate)]
        if not columns:
            return np.zeros(len(draws))
        conditional = self.given(())
        gram, score = products_by_group(
            self.candidates.stretch, conditional.residual_columns(columns), conditional.residual
        )
        drawn = log_evidence(np.tensordot(draws, gram, 1), draws @ score, MEMBER_SIZE)
        return drawn - log_evidence(gram.sum(axis=0), score.sum(axis=0), MEMBER_SIZE)

    def without(self, excluded: Iterable[int]) -> Posterior:
        """Return the posterior with some candidates impossible; their numbers stay."""
        numbers = set(excluded)
        terms = [
            replace(term, odds=IMPOSSIBLE) if number in numbers else term
            for number, term in enumerate(self.terms)
        ]
        return Posterior(replace(self.candidates, terms=terms))
