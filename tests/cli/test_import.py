"""`omnimate import`: what people have becomes recording folders."""

import sys

import numpy as np
import pytest

from omnimate.files.importers.robots import single_truck
from omnimate.files.recordings.folder import load_recording
from omnimate.vehicle.file import save_vehicle
from omnimate.vehicle.parameters import Truck
from tests.files.importers.conftest import COLUMNS, POSES, Maker, write_bag

MAPPING = """
[robot]
wheelbase = 0.3
wheel_diameter = 0.1
counts_per_turn = 1000
"""
ROBOT = single_truck("tried", Truck(0.3, 0.1, 0.1), 1000.0, 0.02)


@pytest.fixture
def bag(tmp_path):
    """Write ticks of two wheels, 20 ms apart, as a ROS 2 bag; return its folder."""
    maker = Maker("sqlite3")
    sent = [
        (f"/{side}_ticks", "std_msgs/msg/Int32", 1.0 + 0.02 * number, maker.ticks(factor * number))
        for number in range(50)
        for side, factor in (("left", 10), ("right", 11))
    ]
    save_vehicle(ROBOT, tmp_path / "vehicle.toml")
    return write_bag(tmp_path / "drive", maker, sent)


def test_a_csv_file_becomes_a_recording_and_its_odometry_is_told(accepted, tmp_path):
    rows = "\n".join(f"{0.05 * row:.2f},{10 * row},{10 * row},{0.01 * row},0,0" for row in range(50))
    (tmp_path / "drive.csv").write_text("t,left,right,x,y,yaw\n" + rows + "\n")
    (tmp_path / "map.toml").write_text(MAPPING + COLUMNS + POSES)
    result = accepted(
        "import", "csv", tmp_path / "drive.csv", tmp_path / "out", "--mapping", tmp_path / "map.toml"
    )
    assert len(load_recording(tmp_path / "out")) == 50
    way = 490 * np.pi * 0.1 / 1000
    assert (
        f"ends {1e3 * (0.49 - way):.1f} mm and 0.00 deg from the last pose, after {way:.2f} m" in result.out
    )


def test_a_bad_csv_file_is_one_sentence_with_the_place(refused, tmp_path):
    (tmp_path / "drive.csv").write_text("t,left,right,x,y,yaw\n0,1,2,0,0,0\n0.1,one,2,0,0,0\n")
    (tmp_path / "map.toml").write_text(MAPPING + COLUMNS + POSES)
    assert "drive.csv:3: column left: 'one' is no number" in refused(
        "import", "csv", tmp_path / "drive.csv", tmp_path / "out", "--mapping", tmp_path / "map.toml"
    )
    assert not (tmp_path / "out").exists()


def test_a_bag_is_listed_with_a_mapping_by_guess_that_imports_it(accepted, bag, tmp_path):
    listed = accepted("import", "rosbag", bag, "--list")
    assert "std_msgs/Int32" in listed.out
    guessed = listed.out.split("# a mapping by guess:")[1]
    (tmp_path / "map.toml").write_text(MAPPING.replace("[robot]", guessed + "[robot]"))
    accepted("import", "rosbag", bag, tmp_path / "out", "--mapping", tmp_path / "map.toml")
    assert load_recording(tmp_path / "out").counts[-1].tolist() == [490, 539]


@pytest.mark.parametrize(
    "stated", [(), ("a.left=/left_ticks",), ("a.left=/left_ticks", "a.right=/right_ticks")]
)
def test_a_bag_is_imported_by_options_and_what_they_leave_open_by_names(accepted, bag, tmp_path, stated):
    vehicle = ("--vehicle", tmp_path / "vehicle.toml")
    options = [part for channel in stated for part in ("--channel", channel)]
    result = accepted("import", "rosbag", bag, tmp_path / "out", *vehicle, *options)
    assert ("by the names in the bag" in result.err) == (len(stated) < 2)
    assert "no stamps" in result.err
    assert load_recording(tmp_path / "out").counts[-1].tolist() == [490, 539]


def test_a_topic_that_is_missing_is_named(refused, bag, tmp_path):
    call = ("import", "rosbag", bag, tmp_path / "out", "--vehicle", tmp_path / "vehicle.toml")
    assert "no topic /mocap" in refused(*call, "--pose", "a=/mocap")
    assert not (tmp_path / "out").exists()


def test_without_the_library_a_bag_says_what_to_install(refused, bag, monkeypatch):
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    assert "pip install 'omnimate[rosbag]'" in refused("import", "rosbag", bag, "--list")


@pytest.mark.parametrize("name", ["drive.mcap", "bag"])
def test_an_exported_drive_is_imported_with_its_poses(omnimate, accepted, small_drive, tmp_path, name):
    if name.endswith(".mcap"):
        pytest.importorskip("mcap")
    assert omnimate("export", small_drive, tmp_path / name).code == 0
    vehicle = small_drive / "vehicle.toml"
    accepted("import", "rosbag", tmp_path / name, tmp_path / "again", "--vehicle", vehicle)
    before, after = (load_recording(folder).poses for folder in (small_drive, tmp_path / "again"))
    assert after.body.tolist() == before.body.tolist()
    assert after.time == pytest.approx(before.time, abs=1e-6)
    assert after.pose == pytest.approx(before.pose, abs=1e-6)


@pytest.mark.parametrize("text", ["", "buy oil\n", "(1.000000) can0 7FF#00\n"])
@pytest.mark.parametrize("is_there", [False, True])
def test_a_log_that_cannot_be_imported_leaves_nothing_new(omnimate, tmp_path, text, is_there):
    save_vehicle(ROBOT, tmp_path / "vehicle.toml")
    (tmp_path / "drive.log").write_text(text)
    out = tmp_path / "out"
    if is_there:
        out.mkdir()
    vehicle = tmp_path / "vehicle.toml"
    assert omnimate("import", "log", tmp_path / "drive.log", out, "--vehicle", vehicle).code == 1
    assert out.exists() == is_there
    assert list(out.glob("*")) == []
