"""Results in the words of those who use them."""

import json

import numpy as np
import pytest

from omnimate.calib.errors import CalibrationError
from omnimate.calib.exports import calibration_json, ros2_parameters, ros2_yaml, vda5050_json, vda5050_wheels
from omnimate.calib.umbmark.experiment import calibrate
from omnimate.calib.umbmark.floor import floor_roughness
from omnimate.calib.umbmark.uncertainty import uncertainty_of
from omnimate.vcan_sim.reference import reference_single, reference_vehicle
from omnimate.vehicle.parameters import Truck
from studies.papers.trials import Trial, floor_covariance

NOMINAL, FOUND = Truck(0.34, 0.150, 0.152), Truck(0.336, 0.1499, 0.1521)


def test_the_controller_multiplies_to_the_calibrated_sizes() -> None:
    """diff_drive_controller: separation and radius times their multipliers are what was calibrated."""
    found = ros2_parameters(NOMINAL, FOUND)
    assert found["wheel_separation"] * found["wheel_separation_multiplier"] == pytest.approx(0.336)
    assert found["wheel_radius"] * found["left_wheel_radius_multiplier"] == pytest.approx(0.1499 / 2)
    assert found["wheel_radius"] * found["right_wheel_radius_multiplier"] == pytest.approx(0.1521 / 2)
    assert found["wheel_radius"] == pytest.approx(0.0755)


def test_the_yaml_is_a_ros_2_parameter_file() -> None:
    """A controller for each truck, with indented numbers; a single truck keeps the plain name."""
    lines = ros2_yaml({"a": (NOMINAL, FOUND)}).splitlines()
    assert lines[:2] == ["diff_drive_controller:", "  ros__parameters:"]
    assert all(line.startswith("    ") and float(line.split(": ")[1]) > 0.0 for line in lines[2:])
    two = ros2_yaml({"a": (NOMINAL, FOUND), "b": (NOMINAL, FOUND)})
    assert "diff_drive_controller_a:" in two
    assert "diff_drive_controller_b:" in two


def test_wheel_definitions_stand_where_the_wheels_do() -> None:
    """VDA 5050: left is +y, truck b stands a link's length behind, every required key is there."""
    wheels = vda5050_wheels(reference_vehicle().with_truck("a", FOUND), 0.03)
    places = [(one["position"]["x"], one["position"]["y"], one["diameter"]) for one in wheels]  # type: ignore[index]  # a dict
    assert places[:2] == [(0.0, 0.168, 0.1499), (0.0, -0.168, 0.1521)]
    assert [place[0] for place in places[2:]] == [-1.0, -1.0]
    assert all(
        set(one) == {"type", "isActiveDriven", "isActiveSteered", "position", "diameter", "width"}
        for one in wheels
    )
    assert len(json.loads(vda5050_json(reference_single(), 0.03))["wheelDefinitions"]) == 2
    with pytest.raises(CalibrationError, match="width"):
        vda5050_wheels(reference_single(), 30.0)


@pytest.mark.parametrize("runs", [1, 5])
def test_json_holds_everything_and_null_for_what_is_unknown(runs: int) -> None:
    """Strict JSON, also with one run each way, whose limits are not numbers."""
    trial = Trial(0.99, 1.001, floor_covariance(0.025), runs=runs)
    one = calibrate(trial.drive(np.random.default_rng(1)))
    known = (uncertainty_of(one), floor_roughness(one.experiment.errors, 0.34))
    (found,) = json.loads(calibration_json([("x", one, one.truck, *known)]), parse_constant=pytest.fail)
    assert found["wheelbase"]["value"] == one.truck.wheelbase
    assert (found["e_b"]["low"] is None) == (runs == 1)
    assert found["ros2"]["wheel_separation_multiplier"] == pytest.approx(found["e_b"]["value"])
