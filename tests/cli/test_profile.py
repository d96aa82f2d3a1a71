"""Profiles through the command: kept by `umbmark` and `calibrate`, listed, applied."""

import pytest

from omnimate.files.recordings.folder import save_recording
from omnimate.motion.paths import umbmark
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth, with_errors
from omnimate.vehicle.file import load_vehicle


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    robot = reference_vehicle()
    true = with_errors(robot, {"a": 1.01}, {"a": 1.001})
    path = tmp_path_factory.mktemp("profile") / "recording"
    save_recording(simulate(robot, Truth(true, seed=1), umbmark(1.5, 2, speed=0.4, link_length=1.0)), path)
    return path


@pytest.mark.parametrize("verb", ["umbmark", "calibrate"])
def test_what_is_kept_under_a_name_is_what_out_writes_once_it_is_applied(omnimate, folder, tmp_path, verb):
    file, out, applied = (tmp_path / name for name in ("floors.toml", "out.toml", "applied.toml"))
    result = omnimate(verb, folder, "--out", out, "--profile", file, "concrete")
    assert result.code == 0
    assert "profile concrete" in result.out
    listed = omnimate("profile", "list", file)
    assert listed.code == 0
    assert "concrete" in listed.out
    nominal = folder / "vehicle.toml"
    done = omnimate("profile", "apply", file, "concrete", "--vehicle", nominal, "--out", applied)
    assert done.code == 0
    assert load_vehicle(applied).trucks == load_vehicle(out).trucks
    assert load_vehicle(applied).trucks != load_vehicle(nominal).trucks
