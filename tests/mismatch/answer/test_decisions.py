"""What is reported of what was found, where rivals are likelier or more than noise is missed."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from omnimate.mismatch import diagnose
from omnimate.mismatch.answer.decisions import beyond_noise, reported, with_likelier_rivals
from omnimate.mismatch.answer.doubts import EVEN, MISFIT, SUREST
from omnimate.mismatch.answer.omnibus import RELEVANT
from omnimate.mismatch.answer.rivals import POSSIBLE
from omnimate.mismatch.diagnosis import Alternative, Change
from tests.mismatch.conftest import finding


def test_what_is_hardly_possible_is_a_trace_unless_a_rival_of_it_is():
    likely, unlikely, trace = (finding("wheelbase", share * POSSIBLE, 0.9) for share in (1.0, 0.9, 2.0))
    rivalled = replace(unlikely, alternatives=(Alternative("unknown", "a", 0.9),))
    assert reported([likely, unlikely, rivalled], [trace]) == ((likely, rivalled), (unlikely, trace))


def test_next_to_a_name_what_has_none_must_be_a_twentieth_of_the_mismatch():
    """The name's law may leave a part that is small. Where no name is sure, none leaves it."""
    named, large, small = (
        finding("wheelbase", 0.9, 0.9),
        finding("unknown", 0.9, RELEVANT),
        finding("unknown", 0.9, 0.9 * RELEVANT),
    )
    assert reported([named, large, small], []) == ((named, large), (small,))
    doubted = replace(named, probability=EVEN)
    assert reported([doubted, small], []) == ((doubted, small), ())
    assert reported([small], [named]) == ((small,), (named,))


@pytest.mark.parametrize("missed", [0.9 * MISFIT, MISFIT])
def test_a_trace_is_a_finding_where_more_than_noise_is_missed_and_nothing_else_is_found(
    missed, regression, drive
):
    trace, other = finding("wheelbase", 0.4, 0.9), finding("wheel_diameter", 0.2, 0.9)
    fit = SimpleNamespace(heldout=Change(9.0, missed), channels={"joint_a": Change(9.0, missed)})
    model = regression(drive(laps=1))
    assert beyond_noise(model, fit, (other,), (trace,)) == ((other,), (trace,))
    expected = ((trace,), ()) if missed >= MISFIT else ((), (trace,))
    assert beyond_noise(model, fit, (), (trace,)) == expected
    found, _ = beyond_noise(model, fit, (), ())
    said = [(one.key, one.probability) for one in found]
    assert said == ([(("unknown", "joint_a"), EVEN)] if missed >= MISFIT else [])


def rivalled(effect, component, probability, *rivals):
    return finding(effect, probability, 0.2, component, tuple(Alternative(*rival) for rival in rivals))


def test_an_error_without_a_name_takes_the_place_of_all_that_it_is_likelier_than():
    """The same error is reported once, with the largest of its probabilities."""
    pushes = rivalled("unknown", "b", 0.0, ("unknown", "a", 1.0))
    delay = rivalled("latency", "joint_a", 0.3, ("unknown", "a", 0.7), ("traction_slip", "a", 0.1))
    [error] = with_likelier_rivals([pushes, delay])
    assert (error.key, error.probability) == (("unknown", "a"), SUREST)
    assert error.explained == pytest.approx(0.4)


@pytest.mark.parametrize(
    "rival", [("unknown", "a", 0.45), ("unknown", "a", 0.55), ("unknown", "a", 0.6), ("bump", "a.left", 0.9)]
)
def test_a_finding_keeps_its_place_unless_an_error_without_a_name_is_likelier_and_asserted(rival):
    """What has another name is no better known than the finding: the fit holds the size of one of them."""
    named = rivalled("wheelbase", "a", 0.4 if rival[2] < 0.5 else 0.6, rival)
    assert with_likelier_rivals([named]) == (named,)


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
    assert answer.findings[0].key == ("unknown", "joint_b")
    assert answer.findings[0].probability == EVEN
    assert "times the largest noise" in answer.says
