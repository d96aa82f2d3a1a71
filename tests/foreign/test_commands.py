"""`omnimate record` on a bus of foreign devices."""

from __future__ import annotations

import shlex

import pytest

from omnimate.files.recordings.folder import load_recording
from tests.foreign.robots import devices

pytestmark = pytest.mark.usefixtures("family")


def test_a_fault_ends_the_drive_with_code_1_its_cause_and_the_command_that_drives_on(
    omnimate, record, bench, tmp_path
):
    bus = bench(devices())
    bus.at(3.0, lambda: bus.nodes[17].fault(0x5000))
    result = record(bus, "--drive", "straight", "--side", "1", "--runs", "1")
    assert result.code == 1
    assert "node 17 (drive of a.left): EMCY 5000h: device hardware" in result.err
    assert "all wheels stopped" in result.out
    assert len(load_recording(tmp_path / "lap").time) > 100

    command = result.err.strip().splitlines()[-1].split("resets a fault: omnimate ")[1]
    again = omnimate(*shlex.split(command))
    assert again.code == 0, again.err
    assert (tmp_path / "lap-2" / "can.log").exists()


def test_a_drive_ends_after_the_seconds_that_were_asked_for_and_stands(record, bench, tmp_path):
    bus = bench(devices())
    result = record(bus, "--drive", "straight", "--seconds", "2")
    assert result.code == 0, result.err
    time = load_recording(tmp_path / "lap").time
    assert time[-1] - time[0] == pytest.approx(2.0, abs=0.02)
    bus.sleep(0.5)
    assert [bus.nodes[node].velocity for node in range(17, 21)] == [0.0] * 4
