"""`omnimate monitor` without a terminal: a log is watched to its end, and what was seen is printed."""

import math
import sys

import pytest

from omnimate.cli.console import out
from omnimate.cli.monitor.verb import AT_ONCE
from omnimate.driver.bus.replay import LogBus
from omnimate.files.recordings.folder import load_recording
from omnimate.vehicle.odometry import dead_reckon


def test_a_recording_is_watched_to_its_end_and_its_odometry_is_that_of_the_recording(accepted, small_drive):
    printed = accepted("monitor", small_drive, "--pace", "1000").out
    assert "the log has ended" in printed
    assert "a.left = " in printed
    frames = (small_drive / "can.log").read_bytes().count(b"\n")
    assert f"{frames} frames" in printed
    recording = load_recording(small_drive)
    for truck in ("a", "b"):
        x, y, theta = dead_reckon(recording, truck)[-1].tolist()
        degrees = math.degrees(math.remainder(theta, 2.0 * math.pi))
        assert f"{truck}: x {x:.3f} m  y {y:.3f} m  {degrees:.1f} degrees" in printed


def test_a_log_is_read_at_once_into_a_pipe_and_as_recorded_on_a_screen_or_for_a_time(
    omnimate, small_drive, monkeypatch, tmp_path
):
    paces = []

    class Replayed(LogBus):
        def __init__(self, frames, pace):
            paces.append(pace)
            super().__init__(frames, AT_ONCE)

    monkeypatch.setattr("omnimate.driver.bus.replay.LogBus", Replayed)
    whole = omnimate("monitor", small_drive)
    assert "the log has ended" in whole.out
    omnimate("monitor", small_drive, "--seconds", "0.1")
    omnimate("monitor", small_drive, "--seconds", "0.1", "--screenshot", tmp_path / "m.svg")
    omnimate("monitor", small_drive, "--pace", "7000")
    assert paces == [AT_ONCE, 1.0, 1.0, 7000.0]


def test_rows_may_be_filtered(omnimate, small_drive):
    result = omnimate("monitor", small_drive / "can.log", "--pace", "100000", "--filter", "181")
    rows = [line.split()[0] for line in result.out.splitlines() if line[:8].strip()]
    assert "181" in rows
    assert "182" not in rows


def test_a_picture_of_the_screen_is_drawn(omnimate, accepted, small_drive, tmp_path, monkeypatch):
    monkeypatch.setenv("NO_COLOR", "")
    result = accepted(
        "monitor", small_drive, "--pace", "1000", "--seconds", "0.1", "--screenshot", tmp_path / "m.svg"
    )
    assert result.out == f"written: {tmp_path / 'm.svg'}\n"
    assert (tmp_path / "m.svg").read_text().startswith("<svg")
    assert omnimate("monitor", small_drive, "--screenshot", tmp_path / "m.svg").code == 1


@pytest.mark.parametrize("name", ["m.png", "m"])
def test_a_picture_that_is_no_svg_is_refused_before_the_bus_is_watched(refused, small_drive, tmp_path, name):
    assert f"{tmp_path / name}: expected a name with .svg" in refused(
        "monitor", small_drive, "--seconds", "9", "--screenshot", tmp_path / name, out=""
    )
    assert not (tmp_path / name).exists()


def test_without_textual_the_extra_is_named(refused, small_drive, monkeypatch):
    monkeypatch.setattr(type(out), "is_terminal", True)
    monkeypatch.setitem(sys.modules, "omnimate.cli.monitor.app", None)
    assert "pip install 'omnimate[monitor]'" in refused("monitor", small_drive)
