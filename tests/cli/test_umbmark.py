"""`omnimate umbmark`: sources in, tables and files out."""

import json
import shutil
from functools import partial

import pytest

from omnimate.files.recordings.folder import save_recording
from omnimate.motion.paths import umbmark as squares
from omnimate.vcan_sim.floor import Bump, Floor
from omnimate.vcan_sim.reference import reference_single
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth, with_errors
from omnimate.vehicle.file import load_vehicle, save_vehicle

TABLE = """direction,x_mm,y_mm,theta_deg
cw,150,152,-1.8
cw,148,139,-1.9
ccw,221,-214,1.2
ccw,207,-209,1.1
"""


@pytest.fixture
def call(accepted):
    return partial(accepted, "umbmark")


@pytest.fixture
def table(tmp_path):
    path = tmp_path / "returns.csv"
    path.write_text(TABLE, encoding="utf-8")
    return path


@pytest.fixture
def nominal(tmp_path):
    path = tmp_path / "vehicle.toml"
    save_vehicle(reference_single(), path)
    return path


def test_a_table_makes_a_calibrated_vehicle(call, table, nominal, tmp_path):
    out = tmp_path / "calibrated.toml"
    call(table, "--side", 4, "--vehicle", nominal, "--out", out)
    before, after = load_vehicle(nominal), load_vehicle(out)
    assert after.trucks["a"].wheelbase == pytest.approx(0.3355, abs=1e-3)
    assert after.with_truck("a", before.trucks["a"]) == before


def test_the_method_decides_what_is_written(call, table, nominal, tmp_path):
    """--method printed writes the mean of x and y, --method exact the inversion of the chain."""
    bases = []
    for method in ("printed", "exact"):
        out = tmp_path / f"{method}.toml"
        call(table, "--side", 4, "--vehicle", nominal, "--out", out, "--method", method)
        bases.append(load_vehicle(out).trucks["a"].wheelbase)
    assert bases[0] != bases[1]
    assert bases[0] == pytest.approx(bases[1], rel=1e-3)


@pytest.mark.parametrize("name", ["other.log", "can.log.gz", "drive.blf"])
def test_only_the_log_of_a_recording_folder_stands_for_it(refused, erring_drive, tmp_path, name):
    folder = shutil.copytree(erring_drive, tmp_path / "squares")
    (folder / name).write_bytes(b"")
    error = refused("umbmark", folder / name, out="")
    assert f"{folder / name}: the log of the recording folder {folder} is can.log" in error


def test_both_trucks_of_a_recording(call, erring_drive, tmp_path):
    """The log of a two-truck recording with fixes of both calibrates both, and draws them."""
    out, figure = tmp_path / "calibrated.toml", tmp_path / "squares.svg"
    result = call(erring_drive / "can.log", "--out", out, "--plot", figure)
    trucks = load_vehicle(out).trucks
    assert trucks["a"].wheelbase == pytest.approx(0.98874 * 0.340, rel=2e-3)
    assert trucks["b"].wheelbase == pytest.approx(0.340 / 0.98874, rel=2e-3)
    assert "recording, truck a" in result.out
    assert "recording, truck b" in result.out
    assert figure.stat().st_size > 10_000


def test_a_calibrated_vehicle_stands_in(call, erring_drive, tmp_path):
    out = tmp_path / "calibrated.toml"
    call(erring_drive, "--out", out)
    assert call(erring_drive, "--vehicle", out).out.count("unlikely to help") == 2


def test_another_robot_s_vehicle_is_refused(refused, erring_drive, nominal):
    assert "another robot" in refused("umbmark", erring_drive, "--vehicle", nominal)


def test_intervals_and_stop_rule(call, table, nominal):
    """Every method has its limits, and the chosen one says what a pass will do."""
    output = call(table, "--side", 4, "--vehicle", nominal).out
    assert sum(" ± " in line and "->" in line for line in output.splitlines()) == 7
    assert "wheelbase 335.15 ± " in output
    assert "this pass will help" in output


def test_check_my_numbers(call, table, nominal):
    output = call(table, "--side", 4, "--vehicle", nominal, "--check").out
    assert [number in output for number in ("(3.2)", "(4.24b)", "(4.33)")] == [True] * 3
    assert "(+150.0 +148.0) / 2" in output


def test_a_tape_scales_wheels_and_wheelbase(call, table, nominal, tmp_path):
    """--tape 10.1 10 writes all three 1 per cent larger than without."""
    trucks = []
    for number, tape in enumerate(([], ["--tape", 10.1, 10])):
        out = tmp_path / f"{number}.toml"
        call(table, "--side", 4, "--vehicle", nominal, "--out", out, *tape)
        trucks.append(load_vehicle(out).trucks["a"])
    plain, scaled = trucks
    assert scaled.wheelbase == pytest.approx(1.01 * plain.wheelbase)
    assert scaled.wheel_diameter_left == pytest.approx(1.01 * plain.wheel_diameter_left)


def test_a_second_pass_multiplies(call, tmp_path):
    nominal = reference_single()
    true = with_errors(nominal, {"a": 0.95}, {"a": 1.004})
    first, vehicle, believed = tmp_path / "nominal.toml", tmp_path / "vehicle.toml", nominal
    save_vehicle(nominal, first)
    for number in (1, 2):
        folder = tmp_path / f"pass{number}"
        save_recording(simulate(believed, Truth(true, seed=number), squares(4.0, 3)), folder)
        result = call(folder, "--out", vehicle, "--previous", first, "--method", "printed")
        believed = load_vehicle(vehicle)
    assert believed.trucks["a"].wheelbase == pytest.approx(0.95 * 0.34, rel=2e-3)
    assert "all passes together: E_b 0.9" in result.out
    (line,) = (line for line in result.out.splitlines() if "all passes" in line)
    assert float(line.split("E_b ")[1].split(",")[0]) == pytest.approx(0.95, rel=2e-3)


@pytest.mark.parametrize(
    ("kind", "words"),
    [("ros2", "wheel_separation_multiplier: 0.98"), ("vda5050", '"wheelDefinitions"'), ("json", '"e_b"')],
)
def test_exports_print_nothing_else(call, table, nominal, kind, words):
    result = call(table, "--side", 4, "--vehicle", nominal, "--export", kind, "--wheel-width", 0.03)
    assert words in result.out
    assert "E_max,syst" not in result.out
    if kind != "ros2":
        json.loads(result.out)


def test_the_extended_umbmark(call, tmp_path):
    """Ten bumps of 10 mm under the right wheel turn the return heading by about 6 degrees."""
    vehicle = reference_single()
    smooth, bumpy = tmp_path / "smooth", tmp_path / "bumpy"
    put = [(lap, 0.5 + 1.2 * number) for lap in (0, 1) for number in range(10)]
    floor = Floor(bumps=tuple(Bump(0.01, wheel="a.right", after=after, lap=lap) for lap, after in put))
    save_recording(simulate(vehicle, Truth(vehicle, seed=1), squares(4.0, 2)), smooth)
    save_recording(simulate(vehicle, Truth(vehicle, floor=floor, seed=2), squares(4.0, 1)), bumpy)
    (line,) = (one for one in call(smooth, "--bumps", bumpy).out.splitlines() if "extended UMBmark" in one)
    worst = float(line.split("differs by ")[1].split(" ")[0])
    assert 3.0 < worst < 9.0
