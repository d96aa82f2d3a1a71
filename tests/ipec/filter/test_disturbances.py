"""Disturbances: each stretch of distrust with what it cost, if that is worth a report."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.ipec.filter.disturbances import NOTABLE, find_disturbances
from omnimate.vehicle.parameters import WHEELS

tables = st.integers(1, 60).flatmap(
    lambda count: st.tuples(st.just(count), st.integers(0, 2**32 - 1), st.sampled_from([1e-4, 1e-3]))
)


@given(tables)
def test_stretches_and_losses_are_those_of_the_table(drawn):
    """A reported stretch is distrusted throughout and not beside it; no larger one is left out."""
    count, seed, size = drawn
    chance = np.random.default_rng(seed)
    alert = np.where(chance.random((count, 4)) < 0.5, 0.1, 0.0)
    lost = np.where(alert > 0.0, size * chance.random((count, 4)), 0.0)
    time = np.arange(float(count))
    reported = find_disturbances(time, alert, lost)
    for disturbance in reported:
        column = WHEELS.index(disturbance.wheel)
        first, last = int(disturbance.start), int(disturbance.end)
        assert (alert[first : last + 1, column] > 0.0).all()
        assert first == 0 or alert[first - 1, column] == 0.0
        assert last == count - 1 or alert[last + 1, column] == 0.0
        assert disturbance.lost == pytest.approx(lost[first : last + 1, column].sum())
        assert disturbance.lost >= NOTABLE
    assert [disturbance.start for disturbance in reported] == sorted(d.start for d in reported)
    left = lost.sum() - sum(disturbance.lost for disturbance in reported)
    stretches = (np.diff((alert > 0.0).astype(int), axis=0, prepend=0) > 0).sum()
    assert left <= NOTABLE * (stretches - len(reported)) + 1e-12


def test_nothing_distrusted_is_nothing_reported():
    assert find_disturbances(np.arange(5.0), np.zeros((5, 4)), np.ones((5, 4))) == ()
