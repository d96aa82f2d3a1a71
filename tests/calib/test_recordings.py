"""Checks before every calibration: one robot, and no encoder that stands still."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from omnimate.calib.errors import CalibrationError, FrozenChannelError
from omnimate.calib.linkage.calibration import calibrate_linkage
from omnimate.calib.paths.drives import drives_of
from omnimate.calib.recordings import frozen_linkage
from omnimate.calib.umbmark.experiment import experiment_of_recordings
from omnimate.motion.paths import umbmark
from omnimate.vcan_sim.reference import reference_single, reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.errors import RecordingError
from omnimate.vehicle.parameters import Truck
from omnimate.vehicle.recording import Recording
from tests.recordings import frozen

VEHICLE = reference_vehicle()


@pytest.fixture(scope="module")
def recording() -> Recording:
    return simulate(VEHICLE, Truth(VEHICLE, seed=1), umbmark(2.0, 1, link_length=1.0))


def test_a_healthy_recording_has_no_frozen_channel(recording: Recording) -> None:
    """Joints and link move in squares, if only a little."""
    assert frozen_linkage(recording) == ()


@pytest.mark.parametrize("use", [experiment_of_recordings, drives_of, calibrate_linkage])
def test_a_drive_that_is_given_twice_is_refused(recording: Recording, use: Callable[..., object]) -> None:
    """It would count double, and the intervals come out too narrow."""
    again = replace(recording, source="copy")
    with pytest.raises(RecordingError, match=r"copy: holds the same drive as .*; give each drive once"):
        use([recording, again], **({"truck": "a"} if use is drives_of else {}))


@pytest.mark.parametrize("channel", ["joint_a", "joint_b", "link"])
def test_a_frozen_channel_of_the_linkage_is_named(recording: Recording, channel: str) -> None:
    """One error for the one that stands still."""
    (advice,) = frozen_linkage(frozen(recording, channel))
    assert advice.severity == "error"
    assert f"{channel} is frozen" in advice.what


@pytest.mark.parametrize(("channel", "wheel"), [("a.left", "left wheel"), ("a.right", "right wheel")])
@pytest.mark.parametrize("start", [0.0, 0.6])
def test_a_frozen_wheel_is_named(recording: Recording, channel: str, wheel: str, start: float) -> None:
    """From the beginning or in the middle; it is not mistaken for a lap that is no square."""
    with pytest.raises(FrozenChannelError, match=f"{wheel}.*did not count.*check its encoder"):
        experiment_of_recordings([frozen(recording, channel, int(start * len(recording)))])


def test_a_robot_that_stands_has_no_frozen_channel(recording: Recording) -> None:
    """Nothing moves, nothing is missed."""
    still = replace(recording, counts=np.tile(recording.counts[:1], (len(recording), 1)))
    assert frozen_linkage(still) == ()


@pytest.mark.parametrize("calibrate", [drives_of, experiment_of_recordings, calibrate_linkage])
def test_recordings_of_two_robots_are_refused_and_so_are_none(recording: Recording, calibrate) -> None:
    """The same robot with another truck, as before and after a calibration, is another one, too."""
    other = VEHICLE.with_truck("a", Truck(0.4, 0.15, 0.15))
    with pytest.raises(CalibrationError, match=r"^other: truck a differs.*expected one robot"):
        calibrate([recording, replace(recording, vehicle=other, source="other")])
    named = replace(VEHICLE, name="twin")
    with pytest.raises(CalibrationError, match="give recordings of one robot at a time"):
        calibrate([recording, replace(recording, vehicle=named)])
    with pytest.raises(CalibrationError, match="no recording given"):
        calibrate([])


@pytest.mark.parametrize("calibrate", [drives_of, experiment_of_recordings])
def test_a_truck_that_is_not_there_is_refused(drive_squares, calibrate) -> None:
    with pytest.raises(CalibrationError, match="no truck b"):
        calibrate([drive_squares(Truck(0.34, 0.15, 0.15), Truck(0.34, 0.15, 0.15))], "b")


def test_robots_of_one_name_are_told_apart_by_their_trucks(recording: Recording) -> None:
    """The message does not give the same name twice."""
    robot = replace(reference_single(), name=VEHICLE.name)
    other = simulate(robot, Truth(robot), umbmark(1.0, 1))
    with pytest.raises(CalibrationError, match=r"has 1 truck\(s\), .* has 2; give recordings of one robot"):
        experiment_of_recordings([recording, other])


def test_encoders_may_be_in_another_order_in_the_other_file(recording: Recording) -> None:
    """It is the same robot."""
    vehicle = replace(VEHICLE, encoders=VEHICLE.encoders[::-1])
    other = replace(
        recording, vehicle=vehicle, counts=recording.counts[:, ::-1], present=recording.present[:, ::-1]
    )
    assert len(experiment_of_recordings([recording, other]).runs) == 4
