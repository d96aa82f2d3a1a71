"""The real part of the proof: tables and figures of what is there, and a line for what is not."""

import pytest
import typer
from typer.testing import CliRunner

from omnimate.cli.prove import prove
from omnimate.evaluation import real_rows
from omnimate.evaluation.real import findings, residual
from omnimate.evaluation.real_rows import optiodom_rows
from omnimate.vehicle.parameters import Truck

CALIBRATED = Truck(0.20114, 0.083708, 0.083606)  # what `omnimate calibrate --optiodom` prints


def call(*arguments):
    app = typer.Typer()
    app.command()(prove)
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def test_recordings_that_are_not_there_are_left_out_and_that_is_said(tmp_path):
    result = call("--real-only", "--data", tmp_path)
    assert result.exit_code == 0
    said = " ".join(result.stdout.split())
    assert all(name in said for name in ("optiodom", "labyrinth_tuc", "drive_ugv"))
    assert said.count("left out") == 3


def test_a_robot_that_is_described_wrongly_is_shown_before_and_after_with_its_figure(shared_data, tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "real" / "labyrinth_tuc").symlink_to(shared_data / "real/labyrinth_tuc")
    result = call("--real-only", "--data", tmp_path, "--figures", tmp_path)
    assert result.exit_code == 0
    assert "as described" in result.stdout
    assert "left and right are exchanged" in " ".join(result.stdout.split())
    assert (tmp_path / "labyrinth.png").read_bytes().startswith(b"\x89PNG")


@pytest.fixture(scope="module")
def row(shared_data):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(real_rows, "_calibrated", lambda _drives, _left_out: CALIBRATED)
        (only,) = optiodom_rows(shared_data / "real/optiodom", "free/")
    return only


def test_a_set_stands_with_the_robot_as_described_calibrated_and_with_what_was_found(row):
    assert row.name == "free/020120212354"
    assert row.calibrated < row.nominal
    assert row.found < row.nominal


def test_a_row_says_what_was_found_and_how_far_it_helps(row):
    assert " -> " in residual(row.diagnosis)
    assert "%" in findings(row.diagnosis)
