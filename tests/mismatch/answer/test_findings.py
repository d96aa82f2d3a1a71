"""What a doubt takes from a name goes to "unknown", and what is not doubted comes first."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.mismatch.answer.doubts import EVEN
from omnimate.mismatch.answer.findings import _alternatives, ordered, without_name
from omnimate.mismatch.answer.omnibus import Leftover, Prediction
from omnimate.mismatch.answer.rivals import POSSIBLE, Rivalry
from omnimate.mismatch.answer.shares import Share
from omnimate.mismatch.candidates.pushes import PUSH_REGIME
from omnimate.mismatch.diagnosis import Where
from tests.mismatch.conftest import finding

KEY = ("count_loss", "b.left")
UNKNOWN = ("unknown", "b.left")


def shares_of(alternatives):
    return {(each.effect, each.component): each.probability for each in alternatives}


@given(likely=st.floats(EVEN + POSSIBLE, 1.0), rival=st.floats(0.0, 1.0))
def test_what_a_doubt_takes_from_a_name_is_the_probability_of_unknown(likely, rival):
    rivals = Rivalry(likely, ((UNKNOWN, (1.0 - likely) * rival),))
    shares = shares_of(_alternatives(rivals, KEY, EVEN))
    assert shares[UNKNOWN] == pytest.approx(likely - EVEN + (1.0 - likely) * rival)


def test_a_name_without_a_doubt_keeps_its_rivals():
    rivals = Rivalry(0.7, ((("wheelbase", "b"), 0.2), (("latency", "link"), 0.001)))
    assert shares_of(_alternatives(rivals, KEY, 0.999)) == {("wheelbase", "b"): 0.2}


def test_what_has_no_name_is_not_its_own_alternative():
    assert _alternatives(Rivalry(0.9, ()), UNKNOWN, EVEN) == ()


def test_a_doubted_name_comes_after_what_is_sure_and_a_possibility_last():
    doubted, sure = finding("count_loss", EVEN, 0.9), finding("unknown", 0.99, 0.1)
    larger, possible = finding("wheelbase", 0.8, 0.3), finding("latency", 0.2, 1.0)
    assert ordered([possible, doubted, sure, larger]) == (larger, sure, doubted, possible)


@pytest.mark.parametrize(("regime", "expected"), [(PUSH_REGIME, [("unknown", "link")]), ("turn rate", [])])
def test_an_error_that_lasts_is_said_next_to_pushes_and_once(regime, expected):
    """What swings looks like pushes at the moments at which it swings most."""
    swing = Prediction("link", "oscillation", Share("link", 0.3), 500.0, np.zeros((1, 1)))
    before = replace(finding("unknown", 0.9, 0.2), where=Where((), (), regime))
    assert [said.key for said in without_name(Leftover(1e-9, (swing,)), [before], 1.0)] == expected
