"""The law of a wheel that crosses an obstacle."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.effects.crossing import SHAPES, crossing_of, crossing_with_loss

radii = st.floats(0.02, 0.5)
parts = st.floats(0.001, 0.9)  # of the radius
shapes = st.sampled_from(SHAPES)


@given(shapes, radii, parts)
def test_what_is_rolled_is_travelled_or_lost_along_the_arc(shape, radius, part):
    crossing = crossing_of(shape, radius, part * radius)
    assert crossing.rolled == pytest.approx(2.0 * crossing.reach * crossing.half_angle)
    assert crossing.travelled == pytest.approx(2.0 * crossing.reach * math.sin(crossing.half_angle))


@given(shapes, radii, parts)
def test_the_loss_grows_from_0_to_the_whole_and_stays_there(shape, radius, part):
    crossing = crossing_of(shape, radius, part * radius)
    lost = crossing.lost_after(np.linspace(-0.1, 1.1, 200) * crossing.rolled)
    assert np.all(np.diff(lost) >= -1e-12 * radius)
    assert lost[0] == pytest.approx(0.0, abs=1e-12 * radius)
    assert lost[-1] == pytest.approx(crossing.lost, abs=1e-9 * radius)


@given(radii, parts)
def test_the_edge_that_loses_as_much_is_found_from_its_loss(radius, part):
    edge = crossing_of("edge", radius, part * radius)
    again = crossing_with_loss(radius, edge.lost)
    assert again.half_angle == pytest.approx(edge.half_angle, rel=1e-6)
    assert again.lost == pytest.approx(edge.lost, rel=1e-9)


@given(radii, parts, st.floats(0.1, 10.0))
def test_a_crossing_scales_with_the_wheel(radius, part, factor):
    small, large = (crossing_of("cable", size, part * size) for size in (radius, factor * radius))
    assert large.lost == pytest.approx(factor * small.lost)
    assert large.half_angle == pytest.approx(small.half_angle)


@given(shapes, radii, parts)
def test_half_of_the_way_has_lost_half(shape, radius, part):
    crossing = crossing_of(shape, radius, part * radius)
    assert crossing.lost_after(0.5 * crossing.rolled) == pytest.approx(
        0.5 * crossing.lost, abs=1e-12 * radius
    )
