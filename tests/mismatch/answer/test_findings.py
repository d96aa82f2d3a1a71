"""What a doubt takes from a name goes to "unknown", and what is not doubted comes first."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.mismatch import diagnose
from omnimate.mismatch.answer.doubts import EVEN, MISFIT, SUREST
from omnimate.mismatch.answer.findings import (
    _alternatives,
    _beyond_noise,
    _ordered,
    _possible,
    _with_likelier_rivals,
    _without_name,
)
from omnimate.mismatch.answer.omnibus import Leftover, Prediction
from omnimate.mismatch.answer.rivals import POSSIBLE, Rivalry
from omnimate.mismatch.answer.shares import Share
from omnimate.mismatch.candidates.pushes import PUSH_REGIME
from omnimate.mismatch.diagnosis import Alternative, Change, Finding, Where

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


def finding(effect, probability, explained):
    return Finding(effect, "b.left", probability, where=Where((), (), ""), explained=explained)


def test_a_doubted_name_comes_after_what_is_sure_and_a_possibility_last():
    doubted, sure = finding("count_loss", EVEN, 0.9), finding("unknown", 0.99, 0.1)
    larger, possible = finding("wheelbase", 0.8, 0.3), finding("latency", 0.2, 1.0)
    assert _ordered([possible, doubted, sure, larger]) == (larger, sure, doubted, possible)


def test_what_is_hardly_possible_is_a_trace_unless_a_rival_of_it_is():
    likely, unlikely, trace = (finding("wheelbase", share * POSSIBLE, 0.9) for share in (1.0, 0.9, 2.0))
    rivalled = replace(unlikely, alternatives=(Alternative("unknown", "a", 0.9),))
    assert _possible([likely, unlikely, rivalled], [trace]) == ((likely, rivalled), (unlikely, trace))


@pytest.mark.parametrize("missed", [0.9 * MISFIT, MISFIT])
def test_a_trace_is_a_finding_where_more_than_noise_is_missed_and_nothing_else_is_found(
    missed, regression, drive
):
    trace, other = finding("wheelbase", 0.4, 0.9), finding("wheel_diameter", 0.2, 0.9)
    fit = SimpleNamespace(heldout=Change(9.0, missed), channels={"joint_a": Change(9.0, missed)})
    model = regression(drive(laps=1))
    assert _beyond_noise(model, fit, (other,), (trace,)) == ((other,), (trace,))
    expected = ((trace,), ()) if missed >= MISFIT else ((), (trace,))
    assert _beyond_noise(model, fit, (), (trace,)) == expected
    found, _ = _beyond_noise(model, fit, (), ())
    said = [(one.key, one.probability) for one in found]
    assert said == ([(("unknown", "joint_a"), EVEN)] if missed >= MISFIT else [])


@pytest.mark.parametrize(("regime", "expected"), [(PUSH_REGIME, [("unknown", "link")]), ("turn rate", [])])
def test_an_error_that_lasts_is_said_next_to_pushes_and_once(regime, expected):
    """What swings looks like pushes at the moments at which it swings most."""
    swing = Prediction("link", "oscillation", Share("link", 0.3), 500.0, np.zeros((1, 1)))
    before = replace(finding("unknown", 0.9, 0.2), where=Where((), (), regime))
    assert [said.key for said in _without_name(Leftover(1e-9, (swing,)), [before], 1.0)] == expected


def rivalled(effect, component, probability, *rivals):
    alternatives = tuple(Alternative(*rival) for rival in rivals)
    return Finding(effect, component, probability, alternatives, Where((), (), ""), explained=0.2)


def test_an_error_without_a_name_takes_the_place_of_all_that_it_is_likelier_than():
    """The same error is reported once, with the largest of its probabilities."""
    pushes = rivalled("unknown", "b", 0.0, ("unknown", "a", 1.0))
    delay = rivalled("latency", "joint_a", 0.3, ("unknown", "a", 0.7), ("traction_slip", "a", 0.1))
    [error] = _with_likelier_rivals([pushes, delay])
    assert (error.key, error.probability) == (("unknown", "a"), SUREST)
    assert error.explained == pytest.approx(0.4)


@pytest.mark.parametrize(
    "rival", [("unknown", "a", 0.45), ("unknown", "a", 0.55), ("unknown", "a", 0.6), ("bump", "a.left", 0.9)]
)
def test_a_finding_keeps_its_place_unless_an_error_without_a_name_is_likelier_and_asserted(rival):
    """What has another name is no better known than the finding: the fit holds the size of one of them."""
    finding = rivalled("wheelbase", "a", 0.4 if rival[2] < 0.5 else 0.6, rival)
    assert _with_likelier_rivals([finding]) == (finding,)


def test_an_encoder_that_scatters_more_than_any_has_is_no_agreement(drive):
    """Nothing predicts how it scatters, so that no quantity of the drive can show it."""
    healthy = drive(laps=2)
    vehicle = healthy.vehicle
    column, resolution = vehicle.channels.index("joint_b"), abs(vehicle.encoder("joint_b").scale)
    scatter = 200.0 * max(0.3, 2e-5 / resolution)  # [counts] four times the largest level
    counts = healthy.counts.copy()
    counts[:, column] += np.rint(np.random.default_rng(1).normal(0.0, scatter, len(counts))).astype(int)
    answer = diagnose([replace(healthy, counts=counts)])
    assert answer.verdict == "mismatch"
    assert (answer.findings[0].effect, answer.findings[0].component) == ("unknown", "joint_b")
    assert answer.findings[0].probability == EVEN
    assert "times the largest noise" in answer.says
