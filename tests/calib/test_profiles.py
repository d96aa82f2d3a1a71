"""Calibrations by name."""

from pathlib import Path

import pytest

from omnimate.calib.errors import CalibrationError
from omnimate.calib.profiles import load_profiles, save_profile, with_profile
from omnimate.vcan_sim.reference import reference_single, reference_vehicle
from omnimate.vehicle.parameters import Truck

CONCRETE, CARPET = Truck(0.336, 0.1499, 0.1501), Truck(0.345, 0.1489, 0.1491)


def test_profiles_come_back(tmp_path: Path) -> None:
    """Two floors, one of them with two trucks; saving one leaves the other."""
    path = tmp_path / "floors.toml"
    save_profile(path, "concrete", {"a": CONCRETE})
    save_profile(path, "thick carpet", {"a": CARPET, "b": CONCRETE})
    save_profile(path, "concrete", {"a": CARPET})
    assert load_profiles(path) == {"concrete": {"a": CARPET}, "thick carpet": {"a": CARPET, "b": CONCRETE}}


def test_a_robot_takes_a_profile(tmp_path: Path) -> None:
    """Its trucks change and nothing else."""
    path = tmp_path / "floors.toml"
    save_profile(path, "concrete", {"a": CONCRETE})
    robot = with_profile(reference_vehicle(), path, "concrete")
    assert robot == reference_vehicle().with_truck("a", CONCRETE)


def test_an_unknown_name_or_truck_is_refused(tmp_path: Path) -> None:
    """With the names that there are."""
    path = tmp_path / "floors.toml"
    save_profile(path, "concrete", {"a": CONCRETE, "b": CONCRETE})
    with pytest.raises(CalibrationError, match="no profile 'ice'; it holds concrete"):
        with_profile(reference_single(), path, "ice")
    with pytest.raises(CalibrationError, match="has a truck b; labmate has none"):
        with_profile(reference_single(), path, "concrete")
    with pytest.raises(CalibrationError, match="needs a name"):
        save_profile(path, " ", {"a": CONCRETE})
