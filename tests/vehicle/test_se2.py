"""SE(2): the group laws."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

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
def test_wrap_stays_in_its_interval_and_keeps_the_direction(angle):
    wrapped = float(wrap(angle))
    assert -np.pi < wrapped <= np.pi
    assert np.isclose(np.cos(wrapped), np.cos(angle), atol=1e-9)
    assert np.isclose(np.sin(wrapped), np.sin(angle), atol=1e-9)


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
