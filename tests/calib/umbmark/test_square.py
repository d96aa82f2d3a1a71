"""The square in closed form."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.calib.apply import corrected_truck
from omnimate.calib.umbmark.square import SIGNS, factor_scales, square_ends
from omnimate.vehicle.arcs import arc, integrate
from omnimate.vehicle.parameters import Truck

LOG = st.floats(-0.1, 0.1)
SMALL_LOG = st.floats(-0.02, 0.02)
DIAMETER = st.floats(0.14, 0.16)


@given(LOG, SMALL_LOG, DIAMETER)
def test_eight_arcs_one_by_one_end_at_the_same_place(log_b: float, log_d: float, right: float) -> None:
    """The closed form is the dead reckoning of four legs and four corners, also from unequal wheels."""
    believed = Truck(0.34, 0.15, right)
    actual = corrected_truck(believed, np.exp(log_b), np.exp(log_d))
    scales, _ = factor_scales(believed, np.array([log_b, log_d]))
    ends, _ = square_ends(believed, 4.0, scales)
    corner = 0.25 * np.pi * believed.wheelbase
    for end, sign in zip(ends, SIGNS, strict=True):
        left = actual.wheel_diameter_left / 0.15 * np.tile([4.0, -sign * corner], 4)
        far = actual.wheel_diameter_right / right * np.tile([4.0, sign * corner], 4)
        driven = integrate(arc(left, far, actual.wheelbase))[-1] - [0.0, 0.0, sign * 2.0 * np.pi]
        assert end == pytest.approx(driven, abs=1e-11)


@given(LOG, SMALL_LOG, DIAMETER)
def test_the_slopes_are_those_of_the_ends(log_b: float, log_d: float, right: float) -> None:
    """Central differences agree with the derivatives, through wheels where the legs are straight and not."""
    truck, logs, step = Truck(0.34, 0.15, right), np.array([log_b, log_d]), 1e-6

    def ends(at: np.ndarray) -> np.ndarray:
        return square_ends(truck, 4.0, factor_scales(truck, at)[0])[0]

    scales, by_logs = factor_scales(truck, logs)
    slopes = square_ends(truck, 4.0, scales)[1] @ by_logs
    for column, nudge in enumerate(step * np.eye(2)):
        wanted = (ends(logs + nudge) - ends(logs - nudge)) / (2.0 * step)
        assert slopes[..., column] == pytest.approx(wanted, abs=1e-5 * np.abs(slopes).max())


def test_many_at_once_are_each_alone() -> None:
    """Leading axes are independent robots."""
    truck = Truck(0.34, 0.15, 0.15)
    logs = np.random.default_rng(0).normal(0.0, 0.01, (5, 4, 2))
    ends, slopes = square_ends(truck, 4.0, factor_scales(truck, logs)[0])
    assert (ends.shape, slopes.shape) == ((5, 4, 2, 3), (5, 4, 2, 3, 3))
    one, _ = square_ends(truck, 4.0, factor_scales(truck, logs[3, 2])[0])
    assert ends[3, 2] == pytest.approx(one, abs=1e-14)
