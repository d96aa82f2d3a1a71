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


@pytest.mark.parametrize("direction", ["cw", "ccw"])
def test_the_other_direction_is_refused(direction: str) -> None:
    """Wheels that turned the other way round contradict the label."""
    with pytest.raises(DirectionError, match="swapped"):
        run(direction, driven="ccw" if direction == "cw" else "cw").check(TRUCK, 4.0)


def test_a_missing_last_turn_is_refused() -> None:
    """270 degrees are named for what they are."""
    with pytest.raises(DirectionError, match="last turn"):
        run("cw", corners=3).check(TRUCK, 4.0)


def test_two_laps_are_refused() -> None:
    """720 degrees are not one square."""
    once = run("ccw")
    twice = SquareRun("ccw", once.absolute, np.vstack([once.wheel_angles] * 2), "twice")
    with pytest.raises(DirectionError, match="not one square"):
        twice.check(TRUCK, 4.0)


def test_the_whole_path_for_the_side_is_refused() -> None:
    """16 m taken for the side does not fit the wheels' way."""
    with pytest.raises(CalibrationError, match="whole path"):
        run("cw").check(TRUCK, 16.0)


def test_the_error_is_absolute_minus_calculated() -> None:
    """(3.1): the believed parameters close the odometry; with others the chain is subtracted."""
    runs = [run("cw"), run("ccw")]
    errors = return_errors(runs, TRUCK, 4.0, "test")
    assert errors.centres == pytest.approx(np.array([[0.1, 0.2, 0.3]] * 2), abs=1e-12)
    other = corrected_truck(TRUCK, 0.99, 1.001)
    again = return_errors(runs, other, 4.0, "test")
    assert again.centres == pytest.approx(errors.centres - square_returns(TRUCK, other, 4.0), abs=1e-12)
