"""One run of the square."""

import math

import numpy as np
import pytest

from omnimate.calib.apply import corrected_truck
from omnimate.calib.errors import CalibrationError, DirectionError
from omnimate.calib.umbmark.exact import square_returns
from omnimate.calib.umbmark.runs import SquareRun, return_errors
from omnimate.vehicle.parameters import Truck

TRUCK = Truck(0.34, 0.15, 0.15)


def run(direction: str, corners: int = 4, driven: str | None = None) -> SquareRun:
    """A run of 4 m legs as TRUCK believes it, split in the middle of each."""
    sign = -1.0 if (driven or direction) == "cw" else 1.0
    turn = sign * math.pi / 4 * TRUCK.wheelbase
    steps = [[2.0, 2.0], [2.0, 2.0], [-turn, turn]] * 4
    angles = np.array(steps[: len(steps) - (4 - corners)]) / 0.075
    return SquareRun(direction, np.array([0.1, 0.2, 0.3]), angles, f"{direction} run")  # type: ignore[arg-type]  # cw, ccw


@pytest.mark.parametrize("direction", ["cw", "ccw"])
def test_a_square_is_accepted(direction: str) -> None:
    """-360 degrees for cw and +360 for ccw, four sides long."""
    run(direction).check(TRUCK, 4.0)


TWICE = SquareRun("ccw", np.zeros(3), np.vstack([run("ccw").wheel_angles] * 2), "twice")


@pytest.mark.parametrize(
    ("drive", "side", "error", "words"),
    [
        (run("cw", driven="ccw"), 4.0, DirectionError, "swapped"),
        (run("ccw", driven="cw"), 4.0, DirectionError, "swapped"),
        (run("cw", corners=3), 4.0, DirectionError, "last turn"),
        (TWICE, 4.0, DirectionError, "not one square"),
        (run("cw"), 16.0, CalibrationError, "whole path"),
    ],
)
def test_what_is_not_one_square_is_named(
    drive: SquareRun, side: float, error: type[CalibrationError], words: str
) -> None:
    """The other direction, a turn too few, two laps, and the whole path for the side."""
    with pytest.raises(error, match=words):
        drive.check(TRUCK, side)


def test_the_error_is_absolute_minus_calculated() -> None:
    """(3.1): the believed parameters close the odometry; with others the chain is subtracted."""
    runs = [run("cw"), run("ccw")]
    errors = return_errors(runs, TRUCK, 4.0, "test")
    assert errors.centres == pytest.approx(np.array([[0.1, 0.2, 0.3]] * 2), abs=1e-12)
    other = corrected_truck(TRUCK, 0.99, 1.001)
    again = return_errors(runs, other, 4.0, "test")
    assert again.centres == pytest.approx(errors.centres - square_returns(TRUCK, other, 4.0), abs=1e-12)
