"""What lies beyond a tolerance: nothing within it, and the whole rest of the error outside of it."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.ipec.tolerance import beyond

errors, tolerances = st.floats(-10.0, 10.0), st.floats(0.0, 5.0)


@given(errors, tolerances)
def test_within_the_tolerance_nothing_is_left_and_outside_the_distance_to_it(error, tolerance):
    expected = max(abs(error) - tolerance, 0.0)
    assert abs(beyond(error, tolerance)) == pytest.approx(expected, abs=1e-12)
    assert beyond(error, tolerance) * error >= 0.0


@given(errors, tolerances)
def test_both_directions_are_alike(error, tolerance):
    assert beyond(-error, tolerance) == -beyond(error, tolerance)


@given(errors)
def test_without_a_tolerance_the_whole_error_is_left(error):
    assert beyond(error, 0.0) == error
