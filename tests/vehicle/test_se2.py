"""SE(2): the group laws, and compiled code that agrees with the array functions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.vehicle import se2
from omnimate.vehicle.se2 import between, compose, inverse, rotation, transform, transport, wrap

poses = st.tuples(st.floats(-50, 50), st.floats(-50, 50), st.floats(-10, 10)).map(np.array)


@given(poses, poses, poses)
def test_composition_is_associative(p, q, r):
    assert np.allclose(compose(compose(p, q), r), compose(p, compose(q, r)), atol=1e-9)


@given(poses)
def test_the_inverse_undoes_on_both_sides(p):
    assert np.allclose(compose(p, inverse(p)), 0.0, atol=1e-9)
    assert np.allclose(compose(inverse(p), p), 0.0, atol=1e-9)


@given(poses, poses)
def test_between_is_what_leads_from_one_to_the_other(p, q):
    assert np.allclose(compose(p, between(p, q)), q, atol=1e-9)


@given(poses, st.tuples(st.floats(-9, 9), st.floats(-9, 9)).map(np.array))
def test_a_transformed_point_keeps_its_distance(p, point):
    assert np.isclose(np.hypot(*(transform(p, point) - p[:2])), np.hypot(*point), atol=1e-9)


@given(st.floats(-1e4, 1e4))
def test_wrapped_angles_stay_in_their_intervals_and_keep_the_direction(angle):
    whole, single = float(wrap(angle)), se2.wrap_angle(angle)
    assert -np.pi < whole <= np.pi
    assert -np.pi <= single < np.pi
    assert np.exp(1j * np.array([whole, single])) == pytest.approx(np.exp(1j * angle), abs=1e-9)


def test_half_a_turn_is_plus_pi():
    assert wrap(-np.pi) == np.pi
    assert wrap(np.pi) == np.pi


@given(poses, st.integers(0, 2**32 - 1))
def test_transport_carries_a_small_error_over_an_increment(increment, seed):
    error = 1e-7 * np.random.default_rng(seed).normal(size=3)
    after = compose(inverse(increment), compose(error, increment))
    second_order = 0.5 * error[2] ** 2 * np.hypot(*increment[:2])  # of turning the increment by the error
    rounding = 8.0 * np.finfo(float).eps * (1.0 + np.linalg.norm(increment))
    assert np.allclose(transport(increment) @ error, after, rtol=0, atol=second_order + rounding)


def test_rotation_turns_the_world_into_a_frame():
    turned = rotation(0.3) @ [1.0, 2.0, 3.0]
    assert np.allclose(turned, [*between([0, 0, 0.3], [1.0, 2.0, 0])[:2], 3.0])


@given(poses, poses)
def test_compiled_code_agrees_with_arrays_and_may_overwrite_its_arguments(first, second):
    x, y, _ = second
    assert se2.rotate_xy(first[2], x, y) == pytest.approx(se2.rotate(first[2], [x, y]), abs=1e-11)
    assert se2.transform_xy(first, x, y) == pytest.approx(transform(first, [x, y]), abs=1e-11)
    matrix, expected = np.empty((3, 3)), compose(first, second)
    se2.write_rotation(matrix, first[2])
    assert matrix == pytest.approx(rotation(first[2]), abs=1e-11)
    se2.write_transport(matrix, first)
    assert matrix == pytest.approx(transport(first), abs=1e-11)
    se2.write_composed(first, first, second)
    assert first == pytest.approx(expected, abs=1e-11)
