"""What is found is relevant where it predicts what no fit has seen; otherwise it is a trace."""

from hypothesis import given
from hypothesis import strategies as st

from omnimate.mismatch.answer.answer import summary_of
from omnimate.mismatch.answer.relevance import is_large, relevant
from omnimate.mismatch.candidates.terms import term
from omnimate.mismatch.diagnosis import Change
from omnimate.mismatch.heldout import held_out
from tests.mismatch.conftest import finding, fit_of


@given(before=st.floats(0.1, 10.0), quieter=st.floats(1.0, 10.0), kept=st.floats(0.0, 0.9))
def test_an_error_without_a_name_is_large_where_it_exceeds_the_noise_of_a_nominal_robot(
    before, quieter, kept
):
    """A named effect that helps as much is large on any robot."""
    misses = [(Change(before, kept * before), quieter * before)]
    is_seen = (1.0 - kept**2) / quieter**2 >= 1.0 - 0.95**2
    assert is_large(finding("unknown"), misses, {"b.left"}) == is_seen
    assert is_large(finding("wheelbase"), misses, {"b.left"})


def relevant_of(fit, *findings):
    residuals = held_out(fit)
    return relevant(findings, fit, residuals, summary_of(fit, residuals))


def test_an_effect_of_the_same_size_in_all_recordings_is_relevant(eccentric):
    fit = fit_of(eccentric(4e-4, 4e-4, 4e-4), term("wheel_eccentricity", "b.left"))
    found = finding("wheel_eccentricity")
    assert relevant_of(fit, found) == ((found,), ())


def test_an_effect_that_one_recording_has_and_others_contradict_is_a_trace(eccentric):
    """Its size in the others says the opposite of what a recording shows, whichever is left out."""
    fit = fit_of(eccentric(4e-4, -4e-4, 1e-4, -2e-4), term("wheel_eccentricity", "b.left"))
    found = finding("wheel_eccentricity")
    assert relevant_of(fit, found) == ((), (found,))


def test_an_effect_that_is_not_there_is_a_trace_next_to_one_that_is(eccentric):
    fit = fit_of(
        eccentric(6e-4, 6e-4, 6e-4), term("wheel_eccentricity", "b.left"), term("joint_bias", "joint_a")
    )
    there, absent = finding("wheel_eccentricity"), finding("joint_bias", component="joint_a")
    assert relevant_of(fit, there, absent) == ((there,), (absent,))


def test_what_no_effect_of_the_fit_describes_is_relevant_next_to_a_name_and_alone(eccentric):
    fit = fit_of(eccentric(6e-4, 6e-4), term("wheel_eccentricity", "b.left"))
    named, lawless = finding("wheel_eccentricity"), finding("unknown", component="a")
    assert relevant_of(fit, named, lawless) == ((named, lawless), ())
    assert relevant_of(fit, lawless) == ((lawless,), ())
