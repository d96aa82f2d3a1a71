"""`omnimate umbmark`: sources in, tables and files out."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from omnimate.calib.errors import CalibrationError, DirectionError, ReturnTableError
from omnimate.calib.profiles import load_profiles
from omnimate.cli.umbmark.verb import umbmark
from omnimate.figures.files import PlotError
from omnimate.files.recordings.folder import save_recording
from omnimate.motion.paths import umbmark as squares
from omnimate.vcan_sim.bumps import Bump
from omnimate.vcan_sim.floor import Floor
from omnimate.vcan_sim.reference import reference_single, reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth, with_errors
from omnimate.vehicle.errors import OmnimateError, VehicleFileError
from omnimate.vehicle.file import load_vehicle, save_vehicle

TABLE = """direction,x_mm,y_mm,theta_deg
cw,150,152,-1.8
cw,148,139,-1.9
ccw,221,-214,1.2
ccw,207,-209,1.1
"""


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
    """The sentence names the kinds of sources."""
    result = call(tmp_path)
    assert isinstance(result.exception, CalibrationError)
    assert "a recording folder or a CSV table" in str(result.exception)


def test_out_takes_one_experiment(table: Path, nominal: Path, tmp_path: Path) -> None:
    """Two tables are two answers for one truck."""
    out = tmp_path / "out.toml"
    result = call(table, table, "--side", 4, "--vehicle", nominal, "--out", out)
    assert "second experiment" in str(result.exception)
    assert not out.exists()


def test_another_robot_s_vehicle_is_refused(recording: Path, nominal: Path) -> None:
    """A single truck's file does not fit a recording of two."""
    result = call(recording, "--vehicle", nominal)
    assert isinstance(result.exception, CalibrationError)
    assert "another robot" in str(result.exception)


def test_intervals_and_stop_rule(table: Path, nominal: Path) -> None:
    """Every method has its limits, and the chosen one says what a pass will do."""
    output = call(table, "--side", 4, "--vehicle", nominal).output
    assert sum(" ± " in line and "->" in line for line in output.splitlines()) == 7
    assert "wheelbase 335.15 ± " in output
    assert "this pass will help" in output


def test_check_my_numbers(table: Path, nominal: Path) -> None:
    """--check prints every formula with its numbers."""
    output = call(table, "--side", 4, "--vehicle", nominal, "--check").output
    assert [number in output for number in ("(3.2)", "(4.24b)", "(4.33)")] == [True] * 3
    assert "(+150.0 +148.0) / 2" in output


def test_a_tape_scales_wheels_and_wheelbase(table: Path, nominal: Path, tmp_path: Path) -> None:
    """--tape 10.1 10 writes all three 1 per cent larger than without."""
    trucks = []
    for number, tape in enumerate(([], ["--tape", 10.1, 10])):
        out = tmp_path / f"{number}.toml"
        assert call(table, "--side", 4, "--vehicle", nominal, "--out", out, *tape).exit_code == 0
        trucks.append(load_vehicle(out).trucks["a"])
    plain, scaled = trucks
    assert scaled.wheelbase == pytest.approx(1.01 * plain.wheelbase)
    assert scaled.wheel_diameter_left == pytest.approx(1.01 * plain.wheel_diameter_left)


def test_a_second_pass_multiplies(tmp_path: Path) -> None:
    """The second recording is driven with the first result; --previous tells the factors of both together."""
    nominal = reference_single()
    true = with_errors(nominal, {"a": 0.95}, {"a": 1.004})
    first, vehicle, believed = tmp_path / "nominal.toml", tmp_path / "vehicle.toml", nominal
    save_vehicle(nominal, first)
    for number in (1, 2):
        folder = tmp_path / f"pass{number}"
        save_recording(simulate(believed, Truth(true, seed=number), squares(4.0, 3)), folder)
        result = call(folder, "--out", vehicle, "--previous", first, "--method", "printed")
        assert result.exit_code == 0
        believed = load_vehicle(vehicle)
    assert believed.trucks["a"].wheelbase == pytest.approx(0.95 * 0.34, rel=2e-3)
    assert "all passes together: E_b 0.9" in result.output
    (line,) = (line for line in result.output.splitlines() if "all passes" in line)
    assert float(line.split("E_b ")[1].split(",")[0]) == pytest.approx(0.95, rel=2e-3)


def test_profiles_are_kept_by_name(table: Path, nominal: Path, tmp_path: Path) -> None:
    """--profile FILE NAME, one floor after the other."""
    path = tmp_path / "floors.toml"
    for name in ("concrete", "carpet"):
        assert call(table, "--side", 4, "--vehicle", nominal, "--profile", path, name).exit_code == 0
    assert set(load_profiles(path)) == {"concrete", "carpet"}


@pytest.mark.parametrize(
    ("kind", "words"),
    [("ros2", "wheel_separation_multiplier: 0.98"), ("vda5050", '"wheelDefinitions"'), ("json", '"e_b"')],
)
def test_exports_print_nothing_else(table: Path, nominal: Path, kind: str, words: str) -> None:
    """What stands on stdout is the document, so that it can be piped."""
    result = call(table, "--side", 4, "--vehicle", nominal, "--export", kind, "--wheel-width", 0.03)
    assert result.exit_code == 0
    assert words in result.stdout
    assert "E_max,syst" not in result.stdout
    if kind != "ros2":
        json.loads(result.stdout)


def test_a_factsheet_needs_the_width_of_the_wheels(table: Path, nominal: Path) -> None:
    """VDA 5050 requires it, and it is not made up."""
    assert "--wheel-width" in str(
        call(table, "--side", 4, "--vehicle", nominal, "--export", "vda5050").exception
    )


def test_one_run_each_way_is_refused_unless_forced(table: Path, nominal: Path, tmp_path: Path) -> None:
    """n = 1: the tables are shown, nothing is written, the exit code is not 0; --force writes."""
    lines = TABLE.splitlines()
    table.write_text("\n".join([lines[0], lines[1], lines[3]]), encoding="utf-8")
    out = tmp_path / "out.toml"
    result = call(table, "--side", 4, "--vehicle", nominal, "--out", out)
    assert result.exit_code != 0
    assert "n = 1" in str(result.exception)
    assert "drive the square five times" in str(result.exception)
    assert not out.exists()
    assert call(table, "--side", 4, "--vehicle", nominal, "--out", out, "--force").exit_code == 0
    assert out.exists()


def test_a_missing_direction_and_a_number_that_is_none_are_refused(table: Path, nominal: Path) -> None:
    """Each sentence says what is wrong and what to do."""
    lines = TABLE.splitlines()
    for rows, words in ((lines[:3], "drive the square in both"), ([*lines, "cw,nan,1,0"], "check the unit")):
        table.write_text("\n".join(rows), encoding="utf-8")
        result = call(table, "--side", 4, "--vehicle", nominal)
        assert isinstance(result.exception, CalibrationError)
        assert words in str(result.exception)


def test_recordings_of_two_robots_are_refused(recording: Path, tmp_path: Path) -> None:
    """The same truck with other parameters is another robot, or the same one after a first pass."""
    other = tmp_path / "other"
    believed = with_errors(reference_vehicle(), {"a": 0.99}, {})
    save_recording(simulate(believed, Truth(believed, seed=2), squares(4.0, 1, link_length=1.0)), other)
    result = call(recording, other)
    assert isinstance(result.exception, CalibrationError)
    assert "expected one robot" in str(result.exception)


def test_a_frozen_channel_of_the_linkage_is_refused(tmp_path: Path) -> None:
    """The squares are fine, but the robot is not: exit code not 0, and which encoder to look at."""
    vehicle = reference_vehicle()
    driven = simulate(vehicle, Truth(vehicle, seed=3), squares(2.0, 2, link_length=1.0))
    counts = driven.counts.copy()
    column = vehicle.channels.index("joint_b")
    counts[:, column] = counts[0, column]
    save_recording(replace(driven, counts=counts), tmp_path / "frozen")
    result = call(tmp_path / "frozen")
    assert isinstance(result.exception, CalibrationError)
    assert "joint_b is frozen" in str(result.exception)


def test_the_extended_umbmark(tmp_path: Path) -> None:
    """Ten bumps of 10 mm under the right wheel turn the return heading by about 6 degrees."""
    vehicle = reference_single()
    smooth, bumpy = tmp_path / "smooth", tmp_path / "bumpy"
    put = [(lap, 0.5 + 1.2 * number) for lap in (0, 1) for number in range(10)]
    floor = Floor(bumps=tuple(Bump(0.01, wheel="a.right", after=after, lap=lap) for lap, after in put))
    save_recording(simulate(vehicle, Truth(vehicle, seed=1), squares(4.0, 2)), smooth)
    save_recording(simulate(vehicle, Truth(vehicle, floor=floor, seed=2), squares(4.0, 1)), bumpy)
    (line,) = (one for one in call(smooth, "--bumps", bumpy).output.splitlines() if "extended UMBmark" in one)
    worst = float(line.split("differs by ")[1].split(" ")[0])
    assert 3.0 < worst < 9.0
