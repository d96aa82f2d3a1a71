"""`omnimate umbmark`: sources in, tables and files out."""

from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from calib.errors import CalibrationError, DirectionError, ReturnTableError
from cli.plots import PlotError
from cli.umbmark import umbmark
from motion.paths import umbmark as squares
from vcan_sim.reference import reference_single, reference_vehicle
from vcan_sim.simulate import simulate
from vcan_sim.truth import Truth, with_errors
from vehicle.errors import OmnimateError, VehicleFileError
from vehicle.file import load_vehicle, save_vehicle
from vehicle.folder import save_recording

TABLE = """direction,x_mm,y_mm,theta_deg
cw,150,152,-1.8
cw,148,139,-1.9
ccw,221,-214,1.2
ccw,207,-209,1.1
"""
SETS = "real/optiodom/diff/square"


def call(*arguments: object):
    app = typer.Typer()
    app.command()(umbmark)
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture
def table(tmp_path: Path) -> Path:
    path = tmp_path / "returns.csv"
    path.write_text(TABLE, encoding="utf-8")
    return path


@pytest.fixture
def nominal(tmp_path: Path) -> Path:
    path = tmp_path / "vehicle.toml"
    save_vehicle(reference_single(), path)
    return path


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Squares of a robot whose trucks both have errors."""
    believed = reference_vehicle()
    truth = Truth(with_errors(believed, {"a": 0.98874, "b": 1.01}, {"a": 1.00084, "b": 0.9992}), seed=1)
    folder = tmp_path_factory.mktemp("drive") / "squares"
    save_recording(simulate(believed, truth, squares(4.0, 2, link_length=1.0)), folder)
    return folder


def test_the_published_row(shared_data: Path) -> None:
    """One OptiOdom folder: wheelbase, diameters, worst return error before and after, from x alone."""
    result = call(shared_data / SETS / "230620202042")
    assert result.exit_code == 0
    (row,) = (line for line in result.output.splitlines() if "printed, x  " in line)
    assert [word in row for word in ("201.46", "84.046", "83.954", "33.3 -> 7.1")] == [True] * 4
    assert "exact chain" in result.output


def test_four_sets_in_one_table(shared_data: Path) -> None:
    """Several folders make one table with a line for each method and folder, none of it cut off."""
    folders = sorted((shared_data / SETS).iterdir())
    lines = call(*folders).output.splitlines()
    assert sum("exact chain" in line for line in lines) == len(folders) == 4
    assert all(sum(line.strip().startswith(folder.name) for line in lines) == 3 for folder in folders)
    assert "…" not in "".join(lines)


def test_a_table_makes_a_calibrated_vehicle(table: Path, nominal: Path, tmp_path: Path) -> None:
    """With side and vehicle given, --out writes the corrected truck and nothing else changes."""
    out = tmp_path / "calibrated.toml"
    result = call(table, "--side", 4, "--vehicle", nominal, "--out", out)
    assert result.exit_code == 0
    before, after = load_vehicle(nominal), load_vehicle(out)
    assert after.trucks["a"].wheelbase == pytest.approx(0.3355, abs=1e-3)
    assert after.with_truck("a", before.trucks["a"]) == before


def test_the_method_decides_what_is_written(table: Path, nominal: Path, tmp_path: Path) -> None:
    """--method printed writes the mean of x and y, --method exact the inversion of the chain."""
    bases = []
    for method in ("printed", "exact"):
        out = tmp_path / f"{method}.toml"
        call(table, "--side", 4, "--vehicle", nominal, "--out", out, "--method", method)
        bases.append(load_vehicle(out).trucks["a"].wheelbase)
    assert bases[0] != bases[1]
    assert bases[0] == pytest.approx(bases[1], rel=1e-3)


def test_both_trucks_of_a_recording(recording: Path, tmp_path: Path) -> None:
    """A two-truck recording with fixes of both calibrates both, and draws them."""
    out, figure = tmp_path / "calibrated.toml", tmp_path / "squares.svg"
    result = call(recording, "--out", out, "--plot", figure)
    assert result.exit_code == 0
    trucks = load_vehicle(out).trucks
    assert trucks["a"].wheelbase == pytest.approx(0.98874 * 0.340, rel=2e-3)
    assert trucks["b"].wheelbase == pytest.approx(1.01 * 0.340, rel=2e-3)
    assert "squares, truck a" in result.output
    assert "squares, truck b" in result.output
    assert figure.stat().st_size > 10_000


def test_one_truck_of_a_recording(recording: Path, tmp_path: Path) -> None:
    """--truck b leaves truck a as it was."""
    out = tmp_path / "calibrated.toml"
    result = call(recording, "--truck", "b", "--out", out)
    assert result.exit_code == 0
    trucks = load_vehicle(out).trucks
    assert trucks["a"] == reference_vehicle().trucks["a"]
    assert trucks["b"] != reference_vehicle().trucks["b"]


def test_a_calibrated_vehicle_stands_in(recording: Path, tmp_path: Path) -> None:
    """Evaluated with the result of its own calibration, the recording has only its scatter left."""
    out = tmp_path / "calibrated.toml"
    call(recording, "--out", out)
    again = call(recording, "--vehicle", out)
    assert again.exit_code == 0
    assert again.output.count("unlikely to help") == 2


@pytest.mark.parametrize(
    ("options", "words"),
    [(["--vehicle", "vehicle.toml"], "--side"), (["--side", "4"], "--vehicle")],
)
def test_a_table_needs_side_and_vehicle(
    table: Path, nominal: Path, options: list[str], words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each that is missing is asked for."""
    monkeypatch.chdir(nominal.parent)
    result = call(table, *options)
    assert isinstance(result.exception, CalibrationError)
    assert words in str(result.exception)


def test_swapped_directions_end_with_an_error_and_no_file(table: Path, nominal: Path, tmp_path: Path) -> None:
    """Case 8: cw and ccw exchanged; neither a vehicle nor a figure is written."""
    lines = TABLE.splitlines()
    swapped = [line.replace("ccw", "?").replace("cw", "ccw").replace("?", "cw") for line in lines[1:]]
    table.write_text("\n".join([lines[0], *swapped]), encoding="utf-8")
    out, figure = tmp_path / "out.toml", tmp_path / "figure.png"
    result = call(table, "--side", 4, "--vehicle", nominal, "--out", out, "--plot", figure)
    assert result.exit_code != 0
    assert isinstance(result.exception, DirectionError)
    assert not out.exists()
    assert not figure.exists()


@pytest.mark.parametrize(
    ("spoil", "kind"),
    [
        (lambda table, _: table.write_text("direction,x_mm,y_mm\ncw,1,?\n"), ReturnTableError),
        (lambda _, nominal: nominal.write_text("name = 'x'\n"), VehicleFileError),
    ],
)
def test_bad_files_end_with_their_error(table: Path, nominal: Path, spoil, kind: type[OmnimateError]) -> None:
    """What cannot be read raises the error of its room, which the command turns into exit code 1."""
    spoil(table, nominal)
    result = call(table, "--side", 4, "--vehicle", nominal)
    assert result.exit_code != 0
    assert isinstance(result.exception, kind)


def test_an_unknown_picture_format_is_refused_first(table: Path, nominal: Path, tmp_path: Path) -> None:
    """Before anything is written."""
    out = tmp_path / "out.toml"
    result = call(table, "--side", 4, "--vehicle", nominal, "--out", out, "--plot", tmp_path / "plot.doc")
    assert isinstance(result.exception, PlotError)
    assert not out.exists()


def test_an_empty_folder_is_no_source(tmp_path: Path) -> None:
    """The sentence names the three kinds of sources."""
    result = call(tmp_path)
    assert isinstance(result.exception, CalibrationError)
    assert "OptiOdom" in str(result.exception)


def test_out_needs_a_vehicle_and_one_experiment(shared_data: Path, nominal: Path, tmp_path: Path) -> None:
    """An OptiOdom folder has no vehicle.toml; two of them are two answers for one truck."""
    one, other = sorted((shared_data / SETS).iterdir())[:2]
    out = tmp_path / "out.toml"
    assert "--vehicle" in str(call(one, "--out", out).exception)
    assert "second experiment" in str(call(one, other, "--vehicle", nominal, "--out", out).exception)
    assert not out.exists()


def test_another_robot_s_vehicle_is_refused(recording: Path, nominal: Path) -> None:
    """A single truck's file does not fit a recording of two."""
    result = call(recording, "--vehicle", nominal)
    assert isinstance(result.exception, CalibrationError)
    assert "another robot" in str(result.exception)
