"""Regressions that are drawn by chance, with white noise, and no recording behind them."""

import itertools
from types import SimpleNamespace

import numpy as np
import pytest

from omnimate.mismatch.candidates.terms import Term
from omnimate.mismatch.evidence.posterior import Posterior

RATE, SPAN = 4, 120.0  # rows in a second, and seconds


class Drawn(SimpleNamespace):
    """What a posterior needs of a regression: rows, columns, times."""


@pytest.fixture(scope="session")
def candidate():
    """Return a function that gives a candidate of one column or more."""

    def built(effect, component, odds=0.01, positive=False, width=1, **fixed):
        return Term(effect, component, (None,) * width, fixed, float(np.log(odds)), positive)

    return built


@pytest.fixture(scope="session")
def drawn():
    """Return a function that gives the posterior of data `X b + e` about candidates with columns X."""

    def posterior(columns, terms, truth, seed, everyday=None, order=None):
        chance = np.random.default_rng([seed, 1])
        count = int(RATE * SPAN)
        assert columns.shape[0] == count
        data = columns @ truth + chance.normal(size=count)
        time = np.arange(count) / RATE
        order = np.arange(count) if order is None else order
        regression = Drawn(
            white=np.column_stack([data, columns])[order],
            time=time[order],
            owner=np.zeros(count, int),
            channel=np.zeros(count, int),
            windows=[SimpleNamespace(time=np.array([0.0, SPAN]))],
        )
        edges = 1 + np.concatenate(([0], np.cumsum([len(term.probes) for term in terms])))
        places = [slice(int(start), int(end)) for start, end in itertools.pairwise(edges)]
        if everyday is None:
            everyday = np.zeros(0, np.int64), np.zeros(0)
        names = {
            column: term.key
            for term, place in zip(terms, places, strict=True)
            for column in range(place.start, place.stop)
        }
        return Posterior(regression, list(terms), places, everyday, names, np.zeros(count))

    return posterior


@pytest.fixture(scope="session")
def waves():
    """Return a function that gives smooth columns, as drives make them, of some information each."""

    def columns(informations, seed):
        chance = np.random.default_rng([seed, 2])
        time = np.arange(int(RATE * SPAN)) / RATE
        made = []
        for information in informations:
            pace, phase = chance.uniform(0.05, 1.0), chance.uniform(0.0, 2.0 * np.pi)
            column = np.cos(2.0 * np.pi * pace * time + phase) + 0.3 * chance.normal(size=len(time))
            made.append(column * np.sqrt(information / (column @ column)))
        return np.stack(made, axis=1)

    return columns
