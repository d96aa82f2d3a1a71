"""Broken input of calibrations against its whole message: tests/data/calib."""

import tomllib
from pathlib import Path

import pytest

from omnimate.calib.errors import CalibrationError
from omnimate.calib.profiles import load_profiles, save_profile
from omnimate.calib.umbmark.experiment import read_table
from omnimate.vehicle.parameters import Truck

DATA = Path(__file__).parents[1] / "data" / "calib"


def cases(name):
    return [
        (case["input"], case["message"])
        for case in tomllib.loads((DATA / name).read_text(encoding="utf-8"))["case"]
    ]


@pytest.mark.parametrize(("text", "message"), cases("return_tables.toml"))
def test_a_broken_table_of_return_errors_is_answered_with_its_message(tmp_path, text, message):
    path = tmp_path / "returns.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(CalibrationError) as caught:
        read_table(path, 4.0)
    assert str(caught.value) == message.replace("FOLDER", str(tmp_path))


@pytest.mark.parametrize(("text", "message"), cases("profiles.toml"))
def test_a_broken_file_of_profiles_is_answered_with_its_message_and_not_overwritten(tmp_path, text, message):
    path = tmp_path / "floors.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(CalibrationError) as caught:
        load_profiles(path)
    assert str(caught.value) == message.replace("FOLDER", str(tmp_path))
    with pytest.raises(CalibrationError):
        save_profile(path, "concrete", {"a": Truck(0.336, 0.1499, 0.1501)})
    assert path.read_text(encoding="utf-8") == text
