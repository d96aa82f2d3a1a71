"""A moment of a drive: what a fix says about odometry."""

import math

import numpy as np
import pytest

from omnimate.motion.drive import Moment


def test_the_error_is_absolute_minus_calculated_with_the_heading_wrapped():
    moment = Moment(None, (1.0, 2.0, math.pi - 0.1), None, np.array([1.5, 1.0, -math.pi + 0.1]))
    assert moment.error == pytest.approx((0.5, -1.0, 0.2))


def test_without_a_fix_there_is_no_error():
    assert Moment(None, (1.0, 2.0, 0.0), 0).error is None
