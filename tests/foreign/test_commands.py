"""`omnimate record` on a bus of foreign devices."""

from __future__ import annotations

import shlex

import pytest

from omnimate.driver.robot import driver as module
from omnimate.files.recordings.folder import load_recording
from omnimate.vehicle.file import save_vehicle
from tests.cli.conftest import omnimate
from tests.foreign.robots import devices, two_trucks

__all__ = ["omnimate"]
pytestmark = pytest.mark.usefixtures("family")


@pytest.fixture
def robot(bench, monkeypatch, tmp_path):
    """Return a bench with a robot, which any URL names, and the file of its vehicle."""
    bus = bench(devices())
    monkeypatch.setattr(module, "open_bus", lambda *_arguments: bus)
    monkeypatch.setattr(bus, "shutdown", lambda: None)  # the bench is looked at afterwards
    save_vehicle(two_trucks(), tmp_path / "vehicle.toml")
    return bus, tmp_path


def test_a_fault_ends_the_drive_with_code_1_its_cause_and_the_command_that_drives_on(omnimate, robot):
    bus, folder = robot
    bus.at(3.0, lambda: bus.nodes[17].fault(0x5000))
    arguments = ["--bus", "virtual://robot", "--vehicle", folder / "vehicle.toml", "--drive", "straight"]
    arguments += ["--side", "1", "--runs", "1"]
    result = omnimate("record", folder / "lap", *arguments)
    assert result.code == 1
    assert "node 17 (drive of a.left): EMCY 5000h: device hardware" in result.err
    assert "all wheels stopped" in result.out
    assert len(load_recording(folder / "lap").time) > 100

    command = result.err.strip().splitlines()[-1].split("resets a fault: omnimate ")[1]
    again = omnimate(*shlex.split(command))
    assert again.code == 0, again.err
    assert (folder / "lap-2" / "can.log").exists()


def test_a_drive_ends_after_the_seconds_that_were_asked_for_and_stands(omnimate, robot):
    bus, folder = robot
    arguments = ["--bus", "virtual://robot", "--vehicle", folder / "vehicle.toml", "--drive", "straight"]
    result = omnimate("record", folder / "lap", *arguments, "--seconds", "2")
    assert result.code == 0, result.err
    time = load_recording(folder / "lap").time
    assert time[-1] - time[0] == pytest.approx(2.0, abs=0.02)
    bus.sleep(0.5)
    assert [bus.nodes[node].velocity for node in range(17, 21)] == [0.0] * 4
