"""A series refuses what is none; units of all kinds become the counts that the encoder would have shown."""

import math

import numpy as np
import pytest

from omnimate.files.errors import SourceError
from omnimate.files.importers.series import Series
from omnimate.files.importers.units import counts_of
from omnimate.vehicle.file import parse_vehicle

TIME = 0.1 * np.arange(11)


@pytest.fixture
def two_trucks(robot_toml):
    return parse_vehicle(robot_toml)


@pytest.mark.parametrize(
    ("channel", "value", "unit", "counts"),
    [
        ("a.left", 40000.0, "counts", 40000),
        ("a.left", 2.0 * math.pi, "rad", 40000),
        ("a.left", 180.0, "deg", 20000),
        ("a.left", 1.5, "turns", 60000),
        ("a.left", 0.15 * math.pi, "m", 40000),
        ("a.left", 150.0 * math.pi, "mm", 40000),
        ("joint_a", 90.0, "deg", 4096),
        ("link", 1.1, "m", 1000),
        ("link", 900.0, "mm", -1000),
    ],
)
def test_a_quantity_becomes_the_nearest_count(two_trucks, channel, value, unit, counts):
    series = Series(np.zeros(1), np.array([value]), unit, "test")
    assert counts_of(series, two_trucks, two_trucks.encoder(channel)).tolist() == [counts]


@pytest.mark.parametrize(("speed", "unit"), [(2.0 * math.pi, "rad/s"), (0.15 * math.pi, "m/s")])
def test_a_constant_speed_counts_up_evenly_from_zero(two_trucks, speed, unit):
    series = Series(TIME, np.full(11, speed), unit, "test")
    np.testing.assert_array_equal(
        counts_of(series, two_trucks, two_trucks.encoder("a.left")), 4000 * np.arange(11)
    )


@pytest.mark.parametrize(
    ("channel", "values", "unit", "problem"),
    [
        ("a.left", [0.5], "counts", "expected whole numbers"),
        ("a.left", [1e300], "counts", "too much"),
        ("joint_a", [1.0], "m", "expected counts, rad, deg, turns"),
        ("link", [1.0], "rad", "expected counts, m, cm, mm"),
        ("a.left", [1.0, np.nan], "m/s", "no speed at 0.1"),
    ],
)
def test_what_cannot_be_counts_is_refused(two_trucks, channel, values, unit, problem):
    series = Series(TIME[: len(values)], np.array(values), unit, "test")
    with pytest.raises(SourceError, match=problem):
        counts_of(series, two_trucks, two_trucks.encoder(channel))


@pytest.mark.parametrize(
    ("time", "value", "problem"),
    [
        ([0.0, 2.0, 1.0], [1.0, 2.0, 3.0], "sample 3: time goes backwards, from 2.0"),
        ([0.0, 1.0, 1.0], [1.0, 2.0, 3.0], "sample 3: time stands still"),
        ([0.0, np.nan, 1.0], [1.0, 2.0, 3.0], "sample 2: time nan"),
        ([-1.0, 0.0, 1.0], [1.0, 2.0, 3.0], "sample 1: time -1.0"),
        ([0.0, 1.0, 2.0], [np.nan] * 3, "no value in it"),
        ([], [], "no value in it"),
    ],
)
def test_bad_times_and_empty_series_are_refused_with_their_place(time, value, problem):
    with pytest.raises(SourceError, match=problem):
        Series(np.array(time, float), np.array(value, float), "counts", "left")
