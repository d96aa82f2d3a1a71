"""The smoother's short cuts give what whole matrices give."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.ipec.filter.adjoint import Adjoint, undo_decay, undo_step, undo_update
from omnimate.ipec.filter.records import JOINT_A, JOINT_BIAS, LINK, POSE, STATES, WANDER
from omnimate.vehicle.compiled import record


def adjoint_by(chance):
    """Return an adjoint of chance: a vector and a positive symmetric information."""
    adjoint, root = record(Adjoint), chance.normal(size=(STATES, STATES))
    adjoint["vector"], adjoint["information"] = chance.normal(size=STATES), root @ root.T
    return adjoint


@settings(max_examples=30)
@given(seed=st.integers(0, 2**32 - 1))
def test_a_step_back_is_the_product_of_whole_matrices(seed):
    chance = np.random.default_rng(seed)
    adjoint = adjoint_by(chance)
    whole = np.eye(STATES)
    whole[:POSE, LINK:JOINT_BIAS] += chance.normal(size=(POSE, JOINT_BIAS - LINK))
    vector = whole.T @ adjoint["vector"][0]
    information = whole.T @ adjoint["information"][0] @ whole
    undo_step(adjoint[0], np.ascontiguousarray(whole[:POSE]))
    assert adjoint["vector"][0] == pytest.approx(vector, rel=1e-9, abs=1e-9)
    assert adjoint["information"][0] == pytest.approx(information, rel=1e-9, abs=1e-9)
    assert np.array_equal(adjoint["information"][0], adjoint["information"][0].T)


@settings(max_examples=30)
@given(seed=st.integers(0, 2**32 - 1), number=st.integers(0, 8), lasting=st.floats(0.0, 1.0))
def test_what_wandered_goes_back_as_the_product_of_whole_matrices(seed, number, lasting):
    adjoint, whole = adjoint_by(np.random.default_rng(seed)), np.eye(STATES)
    whole[WANDER, WANDER] = lasting
    if 3 <= number < 5:
        whole[JOINT_A + number - 3, WANDER] = 1.0 - lasting
    vector = whole.T @ adjoint["vector"][0]
    information = whole.T @ adjoint["information"][0] @ whole
    undo_decay(adjoint[0], lasting, number)
    assert adjoint["vector"][0] == pytest.approx(vector, rel=1e-9, abs=1e-9)
    assert adjoint["information"][0] == pytest.approx(information, rel=1e-9, abs=1e-9)


@settings(max_examples=30)
@given(seed=st.integers(0, 2**32 - 1), sparse=st.booleans())
def test_an_update_goes_back_as_the_product_of_whole_matrices(seed, sparse):
    chance = np.random.default_rng(seed)
    adjoint, gain, row = adjoint_by(chance), chance.normal(size=STATES + 2), chance.normal(size=STATES)
    if sparse:
        row[chance.random(STATES) < 0.5] = 0.0
    push, weight = gain[STATES:]
    whole = np.eye(STATES) - weight * np.outer(gain[:STATES], row)
    vector = whole.T @ adjoint["vector"][0] + push * row
    information = whole.T @ adjoint["information"][0] @ whole + weight * np.outer(row, row)
    undo_update(adjoint[0], row, gain)
    assert adjoint["vector"][0] == pytest.approx(vector, rel=1e-9, abs=1e-9)
    assert adjoint["information"][0] == pytest.approx(information, rel=1e-9, abs=1e-8)
    assert np.array_equal(adjoint["information"][0], adjoint["information"][0].T)
