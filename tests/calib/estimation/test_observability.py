"""Coordinates that a drive does not identify are detected, named, and held."""

import numpy as np
import pytest

from omnimate.calib.estimation.observability import information_bound, unobservable
from omnimate.calib.paths.kinematics import Differential
from omnimate.vehicle.parameters import Truck

COORDINATES = Differential(Truck(0.34, 0.15, 0.15)).coordinates
ALL = np.ones(3, bool)


def information(*directions):
    """Information of one standard deviation 1e-4 along each direction of the coordinates."""
    return sum(np.outer(it, it) for it in map(np.array, directions)) * 1e8


def names(held):
    return [one.name for one in held]


def test_nothing_is_held_where_every_direction_is_told():
    held, free = unobservable(COORDINATES, information([1, 0, 0], [0, 1, 0], [0, 0, 1]), ALL)
    assert held == ()
    assert free.all()


def test_a_wheelbase_without_information_is_held_alone():
    held, free = unobservable(COORDINATES, information([0, 1, 0], [0, 0, 1]), ALL)
    assert names(held) == ["wheelbase"]
    assert free.tolist() == [False, True, True]
    assert "do not identify it" in held[0].reason


def test_the_scale_of_a_closed_square_is_held_and_the_wheelbase_is_not():
    """A square identifies E_d, and the wheelbase relative to the mean diameter, which a tape gives better."""
    held, _ = unobservable(COORDINATES, information([1, -1, 0], [0, 0, 1]), ALL)
    assert names(held) == ["mean diameter (E_s)"]


def test_a_combination_is_held_as_a_whole():
    held, _ = unobservable(COORDINATES, information([0, 1, 0], [1.57, 0, 11.8]), ALL)
    assert sorted(names(held)) == ["diameter ratio (E_d)", "wheelbase"]
    assert all("combination of wheelbase and diameter ratio (E_d)" in one.reason for one in held)


def test_a_weak_bound_is_stated_in_per_cent():
    weak = information([1, 0, 0], [0, 0, 1]) + np.diag([0.0, 0.01**-2, 0.0])
    held, _ = unobservable(COORDINATES, weak, ALL)
    assert [one.reason for one in held] == ["these drives identify it to 1.0 % only"]


def test_the_bound_is_the_inverse_on_what_is_free_and_nothing_elsewhere():
    chance = np.random.default_rng(0)
    half = chance.normal(size=(3, 3)) * [[1.0], [1e3], [1e-3]]
    full = half @ half.T
    free = np.array([True, False, True])
    bound = information_bound(full, free)
    assert not bound[1].any()
    assert bound[np.ix_(free, free)] == pytest.approx(np.linalg.inv(full[np.ix_(free, free)]), rel=1e-6)
