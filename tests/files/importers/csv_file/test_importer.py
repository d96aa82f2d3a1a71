"""A CSV file and a mapping become a recording; what is wrong is named with file, line and column."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnimate.files.errors import MappingError, SourceError
from omnimate.files.importers.csv_file.importer import read_csv
from omnimate.vehicle.errors import VehicleFileError
from omnimate.vehicle.file import save_vehicle
from tests.files.importers.conftest import COLUMNS, POSES

MAPPING = 'vehicle = "vehicle.toml"\n' + COLUMNS
ROWS = "t,left,right\n0,1,2\n0.02,3,4\n"


@pytest.fixture
def folder(tmp_path, robot):
    save_vehicle(robot, tmp_path / "vehicle.toml")
    return tmp_path


def written(folder, text, mapping=MAPPING):
    (folder / "drive.csv").write_text(text)
    (folder / "map.toml").write_text(mapping)
    return folder / "drive.csv", folder / "map.toml"


def as_csv(recording, delimiter=",", ending="\n"):
    """Return a recording as a CSV file; a sample without a pose leaves it empty."""
    poses = dict(zip(recording.poses.time.tolist(), recording.poses.pose.tolist(), strict=True))
    lines = [delimiter.join(["t", "left", "right", "x", "y", "yaw"])]
    for time, (left, right) in zip(recording.time.tolist(), recording.counts.tolist(), strict=True):
        cells = [time, left, right, *poses.get(time, ["", "", ""])]
        lines.append(delimiter.join(map(str, cells)))
    return ending.join([*lines, ""])


@pytest.mark.parametrize("delimiter", [",", ";", "\t", "|"])
def test_a_recording_written_as_csv_comes_back_with_the_same_counts_and_poses(folder, drive, delimiter):
    back = read_csv(*written(folder, as_csv(drive, delimiter), MAPPING + POSES))
    np.testing.assert_array_equal(back.time, drive.time)
    np.testing.assert_array_equal(back.counts, drive.counts)
    np.testing.assert_array_equal(back.poses.pose, drive.poses.pose)
    assert back.vehicle == drive.vehicle


@settings(max_examples=30)
@given(
    st.lists(st.tuples(st.integers(-200, 200), st.integers(-200, 200)), min_size=2, max_size=20),
    st.sampled_from([("s", 1.0), ("ms", 1e3), ("us", 1e6), ("ns", 1e9)]),
)
def test_any_unit_of_time_gives_the_same_recording(folder, steps, unit):
    name, factor = unit
    counts = np.cumsum(np.array(steps), axis=0)
    time = 10.0 + 0.02 * np.arange(len(steps))
    rows = [f"{round(t * factor, 6)},{a},{b}" for t, (a, b) in zip(time, counts.tolist(), strict=True)]
    mapping = MAPPING.replace('column = "t"', f'column = "t"\nunit = "{name}"')
    back = read_csv(*written(folder, "\n".join(["t,left,right", *rows]), mapping))
    np.testing.assert_array_equal(back.counts, counts)
    np.testing.assert_allclose(back.time, time, atol=1e-9)


@pytest.mark.parametrize(
    "text",
    [
        ROWS,
        "\ufeff T , LEFT,Right \r\n0,1,2\r\n0.02,3,4\r\n",
        "# made by a robot\n#t [s],left [counts],right [counts]\n0,1,2\n0.02,3,4\n",
        '"t";"left";"right"\n0,00;1;2\n0,02;3;4\n',
        "t left   right\n0    1 2\n0.02 3 4\n",
        "t\tleft\tright\t\n0\t1\t2\t\n0.02\t3\t4\t\n\n\n",
        "t,left (ticks),right (ticks)\n0,1,2\n% a remark\n0.02,3,4",
    ],
)
def test_delimiters_headers_remarks_and_decimal_commas_of_all_kinds_are_understood(folder, text):
    assert read_csv(*written(folder, text)).counts.tolist() == [[1, 2], [3, 4]]


def test_columns_may_be_numbered_where_there_is_no_header(folder):
    mapping = MAPPING.replace('"t"', "1").replace('"left"', "3").replace('"right"', "2")
    assert read_csv(*written(folder, "0,1,2\n0.02,3,4\n", mapping)).counts.tolist() == [[2, 1], [4, 3]]


def test_a_preamble_is_skipped_and_dates_are_times(folder):
    mapping = MAPPING.replace('"t"', '"t"\nunit = "iso"') + "[csv]\nskip = 2\n"
    dates = "2023-11-14T22:13:20.00,1,2\n2023-11-14 22:13:20.02Z,3,4\n"
    text = f"exported by,someone\n1,2,3\nt,left,right\n{dates}"
    assert read_csv(*written(folder, text, mapping)).time.tolist() == [1.7e9, 1.7e9 + 0.02]


def test_angles_and_increments_become_counts(folder):
    mapping = MAPPING.replace('"left"', '"left"\nunit = "deg"').replace(
        '"right"', '"right"\nincrements = true'
    )
    text = "t,left,right\n0,0,5\n0.02,3.6,5\n0.04,7.2,6\n"
    assert read_csv(*written(folder, text, mapping)).counts.tolist() == [[0, 5], [10, 10], [20, 16]]


def test_an_empty_count_is_a_missing_sample_and_an_empty_pose_an_unknown_one(folder):
    text = "t,left,right,x,y,yaw\n0,1,2,0,0,0\n0.02,,3,,,\n0.04,4,5,1,2,\n"
    back = read_csv(*written(folder, text, MAPPING + POSES))
    assert back.is_present("a.left").tolist() == [True, False, True]
    np.testing.assert_array_equal(back.poses.pose, [[0.0, 0.0, 0.0], [1.0, 2.0, np.nan]])


def test_poses_of_another_file_on_a_shifted_clock_in_millimetres_and_degrees(folder):
    (folder / "mocap.csv").write_text("stamp;px;py;heading;s\n5000;100;200;190;1\n5020;110;210;-90;2\n")
    poses = """
[poses.a]
file = "mocap.csv"
x = "px"
y = "py"
theta = "heading"
sigma_x = "s"
length = "mm"
angle = "deg"
time = { column = "stamp", unit = "ms", offset = -5.0 }
"""
    back = read_csv(*written(folder, ROWS, MAPPING + poses)).poses
    np.testing.assert_allclose(back.time, [0.0, 0.02])
    np.testing.assert_allclose(back.pose[0], [0.1, 0.2, math.radians(-170.0)])
    np.testing.assert_allclose(back.sigma, [[0.001, np.nan, np.nan], [0.002, np.nan, np.nan]])


def test_a_standard_deviation_of_zero_is_unknown_and_a_negative_one_is_named_with_its_line(folder):
    text = "t,left,right,x,y,yaw,s\n0,1,2,0,0,0,1\n0.02,2,3,,,,\n0.04,4,5,1,2,0,{}\n"
    unknown = read_csv(*written(folder, text.format(0), MAPPING + POSES + 'sigma_x = "s"\n'))
    assert np.isnan(unknown.poses.sigma[-1, 0])
    text = text.format(-1)
    with pytest.raises(SourceError, match=r"csv:4: .*expected a standard deviation above 0"):
        read_csv(*written(folder, text, MAPPING + POSES + 'sigma_x = "s"\n'))


def test_a_robot_may_stand_in_the_mapping_itself(folder):
    robot = "[robot]\nwheelbase = 0.5\nwheel_diameter = 0.2\ncounts_per_turn = 1000\n"
    mapping = MAPPING.replace('vehicle = "vehicle.toml"', "") + robot
    truck = read_csv(*written(folder, ROWS, mapping)).vehicle.trucks["a"]
    assert (truck.wheelbase, truck.wheel_diameter_left, truck.wheel_diameter_right) == (0.5, 0.2, 0.2)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("t,left,right\n0,1,2\n\n0.02,3,4\n0.01,5,6\n", r"drive\.csv:5: column t: time goes backwards"),
        ("t,left,right\n0,1,2\n,3,4\n", r"drive\.csv:3: column t: time nan"),
        ("t,left,left,right\n0,1,2,3\n", "column 'left' stands 2 times"),
        ("0,1,2\n0.02,3,4\n", "no header; name columns by number, 1 to 3"),
    ],
)
def test_a_bad_file_is_refused_with_the_place(folder, text, problem):
    with pytest.raises(SourceError, match=problem):
        read_csv(*written(folder, text))


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ('column = "t"', 'column = "t"\nunits = "s"', "unknown key 'units'"),
        ('column = "left"', "column = true", "a column's name, or its number"),
        ("vehicle = ", "vehicle = = ", r"map\.toml: cannot be read"),
        ("vehicle.toml", "none.toml", r"none\.toml"),
    ],
)
def test_a_bad_mapping_is_refused_with_its_key(folder, old, new, problem):
    with pytest.raises((MappingError, VehicleFileError), match=problem):
        read_csv(*written(folder, ROWS, MAPPING.replace(old, new)))


@pytest.mark.parametrize("name", ["drive.csv", "map.toml"])
def test_a_file_that_is_no_utf_8_is_refused_with_what_to_do(folder, name):
    paths = written(folder, ROWS)
    (folder / name).write_bytes("Größe".encode("latin-1"))
    with pytest.raises((SourceError, MappingError), match=rf"{name}: .*save the file as UTF-8"):
        read_csv(*paths)


@settings(max_examples=100)
@given(
    st.binary(max_size=200) | st.text(alphabet="0123456789.,;- \n\tnaetlfrigh", max_size=120).map(str.encode)
)
def test_no_file_whatsoever_ends_in_anything_but_a_recording_or_a_sentence(folder, content):
    path, mapping = written(folder, "")
    path.write_bytes(b"t,left,right\n" + content)
    problem = str(path)
    try:
        read_csv(path, mapping)
    except SourceError as error:
        problem = str(error)
    assert str(path) in problem
