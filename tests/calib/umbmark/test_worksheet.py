"""Check my numbers."""

import numpy as np
import pytest

from omnimate.calib.apply import corrected_truck, factors_between
from omnimate.calib.umbmark.printed import solve_printed
from omnimate.calib.umbmark.return_errors import ReturnErrors
from omnimate.calib.umbmark.worksheet import worksheet
from omnimate.vehicle.parameters import Truck
from studies.papers.trials import LABMATE, Trial, floor_covariance


def test_it_ends_at_the_printed_method_s_result() -> None:
    """Step by step as by the solver, to rounding."""
    errors = Trial(0.98874, 1.00084, floor_covariance(0.025)).drive(np.random.default_rng(1)).errors
    value = {step.symbol: step.value for step in worksheet(errors, LABMATE)}
    printed = solve_printed(errors, LABMATE.wheelbase)
    assert value["E_b"] == pytest.approx(printed.e_b, rel=1e-12)
    assert value["E_d"] == pytest.approx(printed.e_d, rel=1e-12)
    factors = factors_between(LABMATE, corrected_truck(LABMATE, printed.e_b, printed.e_d))
    assert value["c_L"] == pytest.approx(factors.c_left, rel=1e-9)
    assert value["c_R"] == pytest.approx(factors.c_right, rel=1e-9)
    assert value["E_max,syst"] == pytest.approx(1e3 * errors.e_max_syst)
    assert value["b_actual"] == pytest.approx(340.0 * printed.e_b)


def test_every_formula_of_the_paper_stands_in_its_order() -> None:
    """From (3.2) to (4.33)."""
    errors = ReturnErrors(np.array([[0.15, 0.15, 0.0]]), np.array([[0.2, -0.2, 0.0]]), 4.0)
    numbers = [step.number for step in worksheet(errors, LABMATE)]
    first = ["3.2", "3.3", "3.4", "4.20a", "4.20b", "4.24a", "4.24b", "4.21", "4.22", "4.26", "4.27"]
    wanted = [*first, *(f"4.{last}" for last in range(28, 34))]
    assert [number for number in dict.fromkeys(numbers) if number != "note 2"] == wanted


def test_the_written_numbers_give_the_written_value() -> None:
    """A pocket calculator that takes (3.2), (3.3) and E_b as they stand comes to the same."""
    errors = ReturnErrors(np.array([[0.15, 0.16, 0.0], [0.14, 0.15, 0.0]]), np.array([[0.2, -0.2, 0.0]]), 4.0)
    steps = {step.symbol: step for step in worksheet(errors, LABMATE)}
    assert steps["x_cg,cw"].how == "(+150.0 +140.0) / 2"
    assert steps["x_cg,cw"].value == pytest.approx(145.0)
    assert steps["r_cg,cw"].how == "sqrt(145.00^2 + 155.00^2)"
    top, below = (
        float(part) for part in steps["E_b,x"].how.replace("(90 + ", "").replace(")", "").split(" / ")
    )
    assert steps["E_b,x"].value == pytest.approx(top / (90.0 + below), rel=1e-5)


def test_equal_and_unequal_wheels() -> None:
    """No curve is an infinite radius and E_d = 1; unequal wheels multiply into the ratio."""
    straight = ReturnErrors(np.array([[0.1, 0.1, 0.0]]), np.array([[0.1, -0.1, 0.0]]), 4.0)
    values = {step.symbol: step.value for step in worksheet(straight, LABMATE)}
    assert np.isinf(values["R_x"])
    assert values["E_d"] == 1.0
    values = {step.symbol: step.value for step in worksheet(straight, Truck(0.34, 0.15, 0.152))}
    assert values["D_R/D_L"] == pytest.approx(0.152 / 0.15)
    assert values["c_L"] == pytest.approx(1.0)
