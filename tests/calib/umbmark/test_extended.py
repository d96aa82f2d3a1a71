"""The extended UMBmark."""

import math

import numpy as np
import pytest

from omnimate.calib.errors import CalibrationError
from omnimate.calib.umbmark.extended import extended_umbmark


def test_worst_and_average() -> None:
    """O 3 takes the worst lap; the report of 1994 adds the averages of both directions."""
    result = extended_umbmark([0.01, 0.03], [-0.02], [0.12, -0.08], [0.03, -0.04])
    assert result.systematic == pytest.approx([0.02, -0.02])
    assert result.worst == pytest.approx(0.10)
    assert result.average == pytest.approx(0.10 + 0.035)


def test_ten_bumps_of_the_paper() -> None:
    """Ten bumps of 0.6 degrees each turn a robot by 6 degrees, whatever its systematic error was."""
    smooth = np.radians([-1.7, -1.6, -1.8])
    result = extended_umbmark(smooth, -smooth, [math.radians(-7.7)], [math.radians(7.7)])
    assert math.degrees(result.worst) == pytest.approx(6.0)


@pytest.mark.parametrize("missing", range(4))
def test_what_is_missing_is_named(missing: int) -> None:
    """Each of the four sets is needed, and every heading in it."""
    sets: list[list[float]] = [[0.1]] * 4
    for hole in ([], [math.nan]):
        sets[missing] = hole
        with pytest.raises(CalibrationError, match=r"(cw|ccw) with(out)? bumps is missing"):
            extended_umbmark(*sets)
