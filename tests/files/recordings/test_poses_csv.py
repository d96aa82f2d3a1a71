"""`poses.csv`: every digit comes back, and a wrong line is named."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.files.recordings.poses_csv import read_poses, write_poses
from omnimate.vehicle.errors import RecordingError
from omnimate.vehicle.recording import Poses

HEADER = "t,body,x,y,theta,sigma_x,sigma_y,sigma_theta\n"


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("1,a,0,0,0,0,0,0,0", "9 columns"),
        ("1,A,0,0,0,,,", "body 'A'"),
        ("1,a,0,0,3.15,,,", "outside (-pi, pi]"),
    ],
)
def test_a_wrong_pose_is_named_with_its_line(tmp_path, line, problem):
    """More of them, word for word, stand in `tests/data/logs/broken_poses.toml`."""
    (tmp_path / "poses.csv").write_text(f"{HEADER}0,a,0,0,0,,,\n{line}\n")
    with pytest.raises(RecordingError) as caught:
        read_poses(tmp_path / "poses.csv")
    assert problem in str(caught.value)
    assert caught.value.source.endswith("poses.csv:3")


def test_empty_cells_and_a_sigma_of_zero_are_unknown_and_pi_may_be_rounded(tmp_path):
    (tmp_path / "poses.csv").write_text(f"{HEADER}0,a,,2,3.1416,,0.1,0\r\n\r\n")
    poses = read_poses(tmp_path / "poses.csv")
    assert np.isnan(poses.pose[0, 0])
    assert abs(poses.pose[0, 2]) == pytest.approx(np.pi, abs=1e-5)
    assert -np.pi < poses.pose[0, 2] <= np.pi
    assert np.isnan(poses.sigma[0]).tolist() == [True, False, True]


def test_poses_are_in_order_of_time_however_the_file_has_them(tmp_path):
    (tmp_path / "poses.csv").write_text(f"{HEADER}0,a,1,,,,,\n2,a,3,,,,,\n0,b,2,,,,,\n2,b,4,,,,,\n")
    poses = read_poses(tmp_path / "poses.csv")
    assert (poses.time.tolist(), "".join(poses.body)) == ([0.0, 0.0, 2.0, 2.0], "abab")
    assert poses.pose[:, 0].tolist() == [1.0, 2.0, 3.0, 4.0]


def test_poses_without_any_line_are_none_of_them(tmp_path):
    (tmp_path / "poses.csv").write_text(HEADER)
    assert read_poses(tmp_path / "poses.csv").pose.shape == (0, 3)


numbers = st.one_of(st.just(np.nan), st.floats(-1e6, 1e6))


@given(
    rows=st.lists(
        st.tuples(
            st.floats(0, 4e9),
            st.sampled_from("ab"),
            numbers,
            numbers,
            st.one_of(st.just(np.nan), st.floats(-3.14, 3.14)),
            st.floats(0, 1, exclude_min=True),
        ),
        max_size=10,
    ).map(lambda rows: sorted(rows, key=lambda row: row[0]))
)
def test_poses_are_written_with_every_digit(tmp_path, rows):
    poses = Poses(
        np.array([row[0] for row in rows], float),
        np.array([row[1] for row in rows], "U1"),
        np.array([row[2:5] for row in rows], float).reshape(-1, 3),
        np.array([(row[5],) * 3 for row in rows], float).reshape(-1, 3),
    )
    write_poses(poses, tmp_path / "poses.csv")
    again = read_poses(tmp_path / "poses.csv")
    assert np.array_equal(again.time, poses.time)
    assert again.pose == pytest.approx(poses.pose, abs=1e-15, nan_ok=True)
    assert np.array_equal(again.sigma, poses.sigma)


def test_headings_that_went_round_are_written_as_a_file_has_them(tmp_path):
    pose = np.zeros((3, 3))
    pose[:, 2] = -4.76, 1.25, np.nan
    write_poses(Poses(np.arange(3.0), np.full(3, "a"), pose, np.full((3, 3), np.nan)), tmp_path / "poses.csv")
    kept = read_poses(tmp_path / "poses.csv")
    np.testing.assert_allclose(kept.pose[:, 2], [2.0 * np.pi - 4.76, 1.25, np.nan])


def test_poses_that_an_editor_saved_as_utf_16_say_so(tmp_path):
    (tmp_path / "poses.csv").write_text("t,body,x,y,theta\n0,a,0,0,0\n", encoding="utf-16")
    with pytest.raises(RecordingError, match="it is UTF-16; save the file as UTF-8"):
        read_poses(tmp_path / "poses.csv")
