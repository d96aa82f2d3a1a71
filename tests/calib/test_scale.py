"""The scaling error, and the refusal to make it up."""

import math

import numpy as np
import pytest

from omnimate.calib.errors import CalibrationError
from omnimate.calib.scale import Scale, scale_from_straights, scale_from_tape, scaled_truck
from omnimate.calib.umbmark.assessment import advise_on_recordings
from omnimate.calib.umbmark.exact import square_returns
from omnimate.motion.paths import umbmark
from omnimate.motion.program import LINE, Program, Row, in_lap, rest
from omnimate.vcan_sim.floor import Floor
from omnimate.vcan_sim.reference import reference_single
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.parameters import Truck
from omnimate.vehicle.recording import Recording
from omnimate.vehicle.sonar import Sonar

NOMINAL = reference_single()
LARGE = Truck(0.340 * 1.01, 0.150 * 1.01, 0.150 * 1.01)


def straights(actual: Truck, seed: int = 0) -> Recording:
    """Three straights of 3 m one after the other, with a fix at each stop."""
    rows = [rest(2.0, fix=True)]
    for lap in range(3):
        rows += [*in_lap(lap, [Row(LINE, x=3.0 * (lap + 1), speed=0.3), rest(0.5)]), rest(2.0, fix=True)]
    truth = Truth(NOMINAL.with_truck("a", actual), floor=Floor(1e-4), sonar=Sonar(sigma=0.0005), seed=seed)
    return simulate(NOMINAL, truth, Program("straight", tuple(rows), ("none",) * 3, None, "parallel"))


def test_a_tape_tells_it() -> None:
    """Measured over calculated; several straights tell how well."""
    assert scale_from_tape([10.05], [10.0]).e_s == pytest.approx(1.005)
    assert math.isnan(scale_from_tape([10.05], [10.0]).sigma)
    several = scale_from_tape([10.05, 10.06, 5.02], [10.0, 10.0, 5.0])
    assert several.e_s == pytest.approx(25.13 / 25.0)
    assert 0.0 < several.sigma < 1e-3


@pytest.mark.parametrize(
    ("measured", "calculated"),
    [([], []), ([10.0], [10.0, 5.0]), ([10.05], [10_000.0]), ([-1.0], [1.0]), ([math.nan], [1.0])],
)
def test_nonsense_of_a_tape_is_refused(measured: list[float], calculated: list[float]) -> None:
    """Nothing measured, millimetres, and lengths that are none."""
    with pytest.raises(CalibrationError, match="tape"):
        scale_from_tape(measured, calculated)


def test_straights_between_fixes_tell_it() -> None:
    """A robot whose wheels are 1 per cent too large shows it; the guard says which option to give."""
    scale = scale_from_straights([straights(LARGE)])
    assert scale.straights == 3
    assert scale.e_s == pytest.approx(1.01, abs=5e-4)
    assert scale.is_significant
    (advice,) = advise_on_recordings([straights(LARGE)], "a")
    assert "--tape 10.09" in advice.do
    assert advise_on_recordings([straights(NOMINAL.trucks["a"])], "a") == ()


def test_closed_squares_do_not_and_it_is_not_made_up() -> None:
    """A recording of squares, however many, is refused with the way to measure it."""
    truth = Truth(NOMINAL.with_truck("a", LARGE), seed=1)
    squares = simulate(NOMINAL, truth, umbmark(2.0, 1))
    with pytest.raises(CalibrationError, match=r"cannot be read from closed squares.*tape"):
        scale_from_straights([squares])
    assert advise_on_recordings([squares], "a") == ()


def test_a_scaled_robot_returns_like_before() -> None:
    """The wheelbase goes with the wheels, so that calibrated squares stay closed to a hundredth."""
    believed, actual = Truck(0.34, 0.15, 0.15), Truck(0.336, 0.1499, 0.1501)
    before, after = (
        square_returns(believed, actual, 4.0),
        square_returns(believed, scaled_truck(actual, 1.01), 4.0),
    )
    assert after[:, 2] == pytest.approx(before[:, 2], abs=1e-12)
    assert after[:, :2] == pytest.approx(1.01 * before[:, :2], rel=1e-9)


def test_a_scale_matters_when_it_is_large_and_sure() -> None:
    """More than 1 in 1000 and more than three standard errors; a single straight has none."""
    assert Scale(1.01, math.nan, 1).is_significant
    assert Scale(1.01, 0.001, 3).is_significant
    assert not Scale(1.01, 0.01, 3).is_significant
    assert not Scale(1.0005, 1e-5, 3).is_significant
    assert not np.any([Scale(1.0, math.nan, 1).is_significant])
