"""From fixes to a return error, U (3.1)."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.service.errors import InvalidValueError
from omnimate.service.umbmark.models import ByWalls, Coordinates, Walls
from omnimate.service.umbmark.samples import pose_of, return_error
from omnimate.vehicle.se2 import compose
from omnimate.vehicle.sonar import Sonar

LENGTH, ANGLE = st.floats(-10.0, 10.0), st.floats(-3.0, 3.0)
POSES = st.builds(lambda x, y, theta: np.array([x, y, theta]), LENGTH, LENGTH, ANGLE)
NEAR = st.builds(
    lambda x, y, theta: np.array([x, y, theta]), st.floats(-1, 1), st.floats(-1, 1), st.floats(-0.3, 0.3)
)


@given(start=POSES, end=POSES)
def test_odometry_that_ends_where_the_robot_is_has_no_error(start, end):
    assert return_error(start, end, end) == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)


@given(start=POSES, end=NEAR, calculated=NEAR)
def test_the_error_does_not_depend_on_where_the_start_lies_in_the_hall(start, end, calculated):
    at_origin = return_error(np.zeros(3), end, calculated)
    elsewhere = return_error(start, np.asarray(compose(start, end)), np.asarray(compose(start, calculated)))
    assert elsewhere == pytest.approx(at_origin, abs=1e-9)


@given(end=NEAR, calculated=NEAR)
def test_from_the_origin_it_is_absolute_minus_calculated(end, calculated):
    assert return_error(np.zeros(3), end, calculated) == pytest.approx(end - calculated, abs=1e-9)


def test_without_the_heading_at_the_end_the_position_is_known_all_the_same():
    error = return_error(np.zeros(3), np.array([0.1, 0.2, math.nan]), np.zeros(3))
    assert error[:2] == pytest.approx([0.1, 0.2])
    assert math.isnan(error[2])


def test_without_the_heading_at_the_start_there_is_no_frame():
    with pytest.raises(InvalidValueError) as caught:
        return_error(np.array([0.0, 0.0, math.nan]), np.zeros(3), np.zeros(3))
    assert caught.value.where == "before.theta"


@given(pose=NEAR)
def test_distances_to_the_walls_are_the_pose_that_they_were_measured_at(pose):
    ranges = Sonar().ranges(pose)
    if not np.isfinite(ranges).all():
        return  # the beam does not return from a wall at this angle
    walls = Walls(**dict(zip(("right_front", "right_rear", "behind"), ranges.tolist(), strict=True)))
    assert pose_of(ByWalls(walls=walls), "after") == pytest.approx(pose, abs=1e-9)


def test_distances_that_no_pose_has_name_their_field():
    walls = Walls(right_front=5.0, right_rear=6.0, behind=2.0)
    with pytest.raises(InvalidValueError) as caught:
        pose_of(ByWalls(walls=walls), "before")
    assert caught.value.where == "before.walls"


def test_coordinates_without_a_heading_are_a_pose_without_a_heading():
    assert pose_of(Coordinates(x=1.0, y=2.0), "after") == pytest.approx([1.0, 2.0, math.nan], nan_ok=True)
