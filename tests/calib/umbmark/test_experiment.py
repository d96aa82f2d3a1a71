"""Experiments and their calibration, from every kind of source."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from omnimate.calib.apply import corrected_truck
from omnimate.calib.errors import CalibrationError, DirectionError
from omnimate.calib.umbmark.exact import square_returns
from omnimate.calib.umbmark.experiment import (
    calibrate,
    experiment_of_recordings,
    experiment_of_table,
    usable_methods,
)
from omnimate.vehicle.parameters import Truck
from omnimate.vehicle.recording import Run

BELIEVED = Truck(0.34, 0.15, 0.15)
ACTUAL = corrected_truck(BELIEVED, 0.98874, 1.00084)


def test_a_recording_gives_the_robot_back(drive_squares) -> None:
    """The exact method finds the parameters that the squares were driven with, to a count."""
    calibration = calibrate(experiment_of_recordings([drive_squares(BELIEVED, ACTUAL)]))
    assert calibration.truck.wheelbase == pytest.approx(ACTUAL.wheelbase, rel=1e-5)
    assert calibration.truck.wheel_diameter_left == pytest.approx(ACTUAL.wheel_diameter_left, rel=1e-6)
    assert calibration.experiment.errors.e_max_syst == pytest.approx(0.311, abs=5e-4)
    assert calibration.errors.e_max_syst < 1e-4
    assert calibration.factors.c_left == pytest.approx(0.99958, abs=5e-6)
    assert calibration.factors.c_right == pytest.approx(1.00042, abs=5e-6)


def test_every_method_improves(drive_squares) -> None:
    """The same runs evaluated again are at least ten times better with each method."""
    experiment = experiment_of_recordings([drive_squares(BELIEVED, ACTUAL, ("cw", "ccw") * 2)])
    assert len(usable_methods(experiment.errors)) == 7
    for method in usable_methods(experiment.errors):
        calibration = calibrate(experiment, method)
        assert calibration.correction.method == method
        assert calibration.errors.e_max_syst < 0.1 * experiment.errors.e_max_syst


def test_one_recording_for_each_direction(drive_squares) -> None:
    """Several recordings of one robot are one experiment."""
    recordings = [drive_squares(BELIEVED, ACTUAL, (direction,)) for direction in ("cw", "ccw")]
    experiment = experiment_of_recordings(recordings)
    assert (len(experiment.errors.cw), len(experiment.errors.ccw)) == (1, 1)


def test_swapped_laps_are_refused(drive_squares) -> None:
    """The wheels tell which way round each lap went."""
    recording = drive_squares(BELIEVED, ACTUAL)
    cw, ccw = recording.run.laps
    laps = (replace(cw, direction="ccw"), replace(ccw, direction="cw"))
    with pytest.raises(DirectionError, match="swapped"):
        experiment_of_recordings([replace(recording, run=Run("umbmark", 4.0, laps))])


def test_the_side_is_stated_or_given(drive_squares) -> None:
    """Without one in run.toml it must be given, and a wrong one does not fit the wheels."""
    recording = drive_squares(BELIEVED, ACTUAL)
    sideless = replace(recording, run=Run("umbmark", None, recording.run.laps))
    with pytest.raises(CalibrationError, match="side"):
        experiment_of_recordings([sideless])
    assert experiment_of_recordings([sideless], side=4.0).errors.side == 4.0
    with pytest.raises(CalibrationError, match="whole path"):
        experiment_of_recordings([sideless], side=16.0)


def test_a_table_is_evaluated_by_the_chain(tmp_path: Path) -> None:
    """Without the wheels' turns the chain stands for them: truth leaves nothing of its own errors."""
    (cw_x, cw_y, _), (ccw_x, ccw_y, _) = 1e3 * square_returns(BELIEVED, ACTUAL, 4.0)
    path = tmp_path / "returns.csv"
    path.write_text(f"direction,x_mm,y_mm\ncw,{cw_x},{cw_y}\nccw,{ccw_x},{ccw_y}\n", encoding="utf-8")
    experiment = experiment_of_table(path, BELIEVED, 4.0)
    assert experiment.evaluate(ACTUAL).e_max_syst < 1e-12
    assert experiment.evaluate(BELIEVED).centres[:, :2] == pytest.approx(experiment.errors.centres[:, :2])
    assert calibrate(experiment).truck.wheelbase == pytest.approx(ACTUAL.wheelbase, rel=1e-9)


def test_a_table_s_headings_stay_in_half_a_turn(tmp_path: Path) -> None:
    """Evaluated with other parameters, heading errors are wrapped."""
    path = tmp_path / "returns.csv"
    text = "direction,x_m,y_m,theta_rad\ncw,-1,-1,-3.1\nccw,-1,1,3.1\n"
    path.write_text(text, encoding="utf-8")
    after = experiment_of_table(path, BELIEVED, 4.0).evaluate(corrected_truck(BELIEVED, 1.1, 1.0))
    assert np.abs(after.centres[:, 2]).max() <= np.pi
