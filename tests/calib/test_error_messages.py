"""Broken input of calibrations against its whole message: tests/data/calib."""

import pytest

from omnimate.calib.errors import CalibrationError
from omnimate.calib.profiles import load_profiles, save_profile
from omnimate.calib.umbmark.experiment import read_table
from omnimate.vehicle.parameters import Truck
from tests.samples import broken


@pytest.mark.parametrize("case", broken("calib/return_tables.toml"))
def test_a_broken_table_of_return_errors_is_answered_with_its_message(tmp_path, case):
    path = tmp_path / "returns.csv"
    path.write_text(case["input"], encoding="utf-8")
    with pytest.raises(CalibrationError) as caught:
        read_table(path, 4.0)
    assert str(caught.value) == case["message"].replace("FOLDER", str(tmp_path))


@pytest.mark.parametrize("case", broken("calib/profiles.toml"))
def test_a_broken_file_of_profiles_is_answered_with_its_message_and_not_overwritten(tmp_path, case):
    path = tmp_path / "floors.toml"
    path.write_text(case["input"], encoding="utf-8")
    with pytest.raises(CalibrationError) as caught:
        load_profiles(path)
    assert str(caught.value) == case["message"].replace("FOLDER", str(tmp_path))
    with pytest.raises(CalibrationError):
        save_profile(path, "concrete", {"a": Truck(0.336, 0.1499, 0.1501)})
    assert path.read_text(encoding="utf-8") == case["input"]
