"""The real part of the proof: tables and figures of what is there, and a line for what is not."""

import typer
from typer.testing import CliRunner

from studies.mismatch.command import prove


def call(*arguments):
    app = typer.Typer()
    app.command()(prove)
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def test_recordings_that_are_not_there_are_left_out_and_that_is_said(tmp_path):
    result = call("--real-only", "--data", tmp_path)
    assert result.exit_code == 0
    said = " ".join(result.stdout.split())
    assert all(name in said for name in ("labyrinth_tuc", "drive_ugv"))
    assert said.count("left out") == 2


def test_a_robot_that_is_described_wrongly_is_shown_before_and_after_with_its_figure(shared_data, tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "real" / "labyrinth_tuc").symlink_to(shared_data / "real/labyrinth_tuc")
    result = call("--real-only", "--data", tmp_path, "--figures", tmp_path)
    assert result.exit_code == 0
    assert "as described" in result.stdout
    assert "left and right are exchanged" in " ".join(result.stdout.split())
    assert (tmp_path / "labyrinth.png").read_bytes().startswith(b"\x89PNG")
