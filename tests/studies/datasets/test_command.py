"""The data sets' commands: recordings of each, and OptiOdom's squares by UMBmark."""

from omnimate.files.recordings.folder import load_recording

SQUARES = "real/optiodom/diff/square"


def test_an_optiodom_set_becomes_recordings_with_poses(studies, shared_data, tmp_path):
    result = studies("import", "optiodom", shared_data / SQUARES / "230620202042", tmp_path / "out")
    assert result.code == 0
    folders = sorted(path.parent for path in (tmp_path / "out").rglob("vehicle.toml"))
    assert len(folders) == 6
    assert load_recording(folders[0]).poses is not None
    assert "nominal odometry ends 23.4 mm and 2.43 deg from the last pose" in result.out


def test_the_labyrinth_and_the_husky_become_recordings(studies, shared_data, tmp_path):
    for name, verb, count in (("labyrinth_tuc", "labyrinth", 1), ("drive_ugv", "husky", 603)):
        result = studies("import", verb, shared_data / "real" / name, tmp_path / verb)
        assert result.code == 0
        assert f"{count} recording(s)" in result.out
        assert len(list((tmp_path / verb).rglob("can.log"))) == count


def test_a_tricycle_is_refused_in_one_sentence(studies, shared_data, tmp_path):
    result = studies("import", "optiodom", shared_data / "real/optiodom/tricyc", tmp_path / "out")
    assert result.code == 1
    assert "differential drives only" in result.err


def test_umbmark_of_a_set_prints_the_published_row(studies, shared_data):
    result = studies("umbmark", shared_data / SQUARES / "230620202042")
    assert result.code == 0
    (row,) = (line for line in result.out.splitlines() if "printed, x  " in line)
    assert [word in row for word in ("201.46", "84.046", "83.954", "33.3 -> 7.1")] == [True] * 4
    assert "exact chain" in result.out
    assert "10000 resamples: E_b 1.0" in result.out


def test_four_sets_make_one_table_of_which_nothing_is_cut_off(studies, shared_data):
    folders = sorted((shared_data / SQUARES).iterdir())
    lines = studies("umbmark", *folders).out.splitlines()
    assert sum("exact chain  " in line for line in lines) == len(folders) == 4
    assert all(sum(line.strip().startswith(folder.name) for line in lines) == 3 for folder in folders)
    tables = [line for line in lines if "exact chain  " in line or "printed, x  " in line]
    assert max(len(line) for line in tables) <= 120
    assert "…" not in "".join(lines)
