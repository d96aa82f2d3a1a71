"""Profiles through the command: kept by `umbmark` and `calibrate`, listed, applied."""

import pytest

from omnimate.vehicle.file import load_vehicle


@pytest.mark.parametrize("verb", ["umbmark", "calibrate"])
def test_what_is_kept_under_a_name_is_what_out_writes_once_it_is_applied(
    accepted, erring_drive, tmp_path, verb
):
    file, out, applied = (tmp_path / name for name in ("floors.toml", "out.toml", "applied.toml"))
    result = accepted(verb, erring_drive, "--out", out, "--profile", file, "concrete")
    assert "profile concrete" in result.out
    listed = accepted("profile", "list", file)
    assert "concrete" in listed.out
    nominal = erring_drive / "vehicle.toml"
    accepted("profile", "apply", file, "concrete", "--vehicle", nominal, "--out", applied)
    assert load_vehicle(applied).trucks == load_vehicle(out).trucks
    assert load_vehicle(applied).trucks != load_vehicle(nominal).trucks
