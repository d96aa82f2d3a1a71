"""Drives whose one RPDO takes control word and target velocity together, and cannot be mapped otherwise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from omnimate.driver.errors import DrivesStopped
from omnimate.driver.robot.recorder import Recorder
from omnimate.files.recordings.folder import load_recording
from tests.foreign.robots import devices, drive, two_trucks

pytestmark = pytest.mark.usefixtures("family")
CONTROL, MODE, TARGET, TORQUE, DUMMY = 0x60400010, 0x60600008, 0x60FF0020, 0x60710010, 0x00050008
SPEED = 4.0  # [rad/s]
COUNTS = SPEED / (2.0 * np.pi) * 40000
QUICK_STOP_ACTIVE = 0x0207


@pytest.fixture
def driving(begun):
    """Return what makes a robot that drives, its drives with this mapping."""

    def make(*rpdo, robot=None, access="ro", **options):
        driver, bus = begun(devices("first", rpdo=rpdo, access=access), robot, **options)
        driver.configure()
        report = driver.enable()
        drive(driver, 1.0)
        return driver, bus, report

    return make


@pytest.mark.parametrize(
    "rpdo", [(CONTROL, TARGET), (TARGET, CONTROL), (CONTROL, MODE, TARGET), (DUMMY, TARGET, CONTROL)]
)
def test_the_robot_drives_with_whatever_order_the_device_has(driving, rpdo):
    _, bus, _ = driving(*rpdo)
    for node in range(17, 21):
        assert bus.nodes[node].velocity == pytest.approx(COUNTS, rel=0.01)
    assert bus.nodes[17].number(0x1600, 1) == rpdo[0]


def test_after_a_trouble_no_pdo_enables_a_drive_again(driving):
    driver, bus, _ = driving(CONTROL, TARGET)
    bus.nodes[17].fault(0x5000)
    with pytest.raises(DrivesStopped):
        drive(driver, 1.0)
    for _ in range(60):
        driver.cycle()
    others = [bus.nodes[node] for node in (18, 19, 20)]
    assert [node.status for node in others] == [QUICK_STOP_ACTIVE] * 3
    assert [node.velocity for node in others] == [0.0] * 3
    driver.enable()
    drive(driver, 1.0)
    assert bus.nodes[17].velocity == pytest.approx(COUNTS, rel=0.01)


def test_a_drive_that_was_disabled_has_no_torque(driving):
    driver, bus, _ = driving(CONTROL, TARGET)
    driver.drives.disable()
    for _ in range(20):
        driver.cycle()
    bus.sleep(1.0)
    assert {bus.nodes[node].status for node in range(17, 21)} == {0x0221}
    assert {bus.nodes[node].velocity for node in range(17, 21)} == {0.0}


def test_what_was_commanded_is_read_from_the_recording(driving, tmp_path):
    robot = two_trucks()
    with Recorder(tmp_path / "run", robot) as recorder:
        _, _, report = driving(CONTROL, TARGET, recorder=recorder)
    assert any("carries 60FFh from bit 16 on" in remark for remark in report[0].remarks)
    recording = load_recording(tmp_path / "run")
    assert recording.commands[-1] == pytest.approx([SPEED] * 4, rel=1e-3)
    assert [drive.start_bit for drive in recording.vehicle.drives] == [16] * 4


def test_a_free_rpdo_is_mapped_as_vehicle_toml_says(driving):
    robot = two_trucks()
    robot = replace(robot, drives=tuple(replace(drive, start_bit=16) for drive in robot.drives))
    _, bus, report = driving(CONTROL, robot=robot, access="rw")
    assert [bus.nodes[17].number(0x1600, sub) for sub in (0, 1, 2)] == [2, CONTROL, TARGET]
    assert not [remark for node in report for remark in node.remarks if "start_bit" in remark]
    assert bus.nodes[17].velocity == pytest.approx(COUNTS, rel=0.01)


def test_an_rpdo_with_an_object_that_the_driver_cannot_know_is_not_taken(driving):
    with pytest.raises(Exception, match="cannot be mapped"):
        driving(CONTROL, TARGET, TORQUE)
