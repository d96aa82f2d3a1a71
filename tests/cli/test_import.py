"""`omnimate import`: what people have becomes recording folders."""

from pathlib import Path

import pytest

from vehicle.folder import load_recording

SQUARES = Path(__file__).resolve().parents[3] / "shared" / "data" / "real" / "optiodom" / "diff" / "square"


@pytest.mark.skipif(not SQUARES.is_dir(), reason="../shared/data/real/optiodom is not there")
def test_an_optiodom_set_becomes_recordings_with_poses(omnimate, tmp_path):
    source = min(SQUARES.iterdir())
    result = omnimate("import", "optiodom", str(source), str(tmp_path / "out"))
    assert result.code == 0
    folders = sorted(path.parent for path in (tmp_path / "out").rglob("vehicle.toml"))
    assert folders
    assert load_recording(folders[0]).poses is not None


def test_a_csv_file_becomes_a_recording(omnimate, tmp_path):
    rows = "\n".join(f"{0.05 * row:.2f},{10 * row},{11 * row}" for row in range(50))
    (tmp_path / "drive.csv").write_text("t,left,right\n" + rows + "\n")
    (tmp_path / "map.toml").write_text(
        '[robot]\nwheelbase = 0.3\nwheel_diameter = 0.1\ncounts_per_turn = 1000\n[time]\ncolumn = "t"\n'
        '[channel."a.left"]\ncolumn = "left"\n[channel."a.right"]\ncolumn = "right"\n'
    )
    arguments = (
        "csv",
        str(tmp_path / "drive.csv"),
        str(tmp_path / "out"),
        "--mapping",
        str(tmp_path / "map.toml"),
    )
    assert omnimate("import", *arguments).code == 0
    assert len(load_recording(tmp_path / "out")) == 50


def test_a_bag_without_a_vehicle_says_what_is_missing(omnimate, tmp_path):
    result = omnimate("import", "rosbag", str(tmp_path / "x.bag"))
    assert result.code == 1
    assert "--vehicle" in result.err or "rosbag" in result.err
