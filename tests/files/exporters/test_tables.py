"""TUM and Parquet: evo and pyarrow read what was computed."""

import numpy as np
import pyarrow.parquet as pq
import pytest
from evo.tools import file_interface
from hypothesis import given

from omnimate.files.errors import ExportError
from omnimate.files.exporters.export import export_drive, export_frames
from omnimate.files.logs.blocks import LogStream
from omnimate.files.logs.frames import ERROR, EXTENDED, FD, REMOTE
from tests.files.exporters.conftest import silent, written_log
from tests.files.logs.any_frames import logs


def test_evo_reads_every_trajectory(drive, tmp_path):
    done = export_drive(drive, tmp_path / "drive.tum", silent)
    assert [path.name for path in done.files] == [
        "drive-odometry_a.tum",
        "drive-odometry_b.tum",
        "drive-ipec_a.tum",
        "drive-ipec_b.tum",
        "drive-measured_a.tum",
    ]
    for path, file in zip(drive.paths, done.files, strict=False):
        seen = file_interface.read_tum_trajectory_file(file)
        known = np.isfinite(path.pose).all(axis=1)
        np.testing.assert_allclose(seen.timestamps, path.time[known], atol=1e-6)
        np.testing.assert_allclose(seen.positions_xyz[:, :2], path.pose[known, :2], rtol=0, atol=0)
        turned = seen.get_orientations_euler()[:, 2] - path.pose[known, 2]
        np.testing.assert_allclose(np.cos(turned), 1.0, atol=1e-12)
        assert seen.check()[0]


def test_a_sample_is_a_row_with_units_and_null_where_a_channel_was_not_read(drive, tmp_path):
    export_drive(drive, tmp_path / "drive.parquet", silent)
    table = pq.read_table(tmp_path / "drive.parquet")
    recording = drive.recording
    assert table["time"].to_pylist() == recording.time.tolist()
    assert table["a.left"][50].as_py() is None
    assert table["a.left"][49].as_py() == recording.wheel_angle("a.left")[49]
    assert table["link"].to_pylist() == recording.link_length().tolist()
    assert table["joint_a.counts"].to_pylist() == recording.channel_counts("joint_a").tolist()
    assert table["ipec_a.theta"].to_pylist() == drive.paths[2].pose[:, 2].tolist()
    assert table.schema.field("ipec_a.theta").metadata == {b"unit": b"rad"}
    assert table.schema.field("link").metadata == {b"unit": b"m"}


def test_poses_and_events_are_tables_beside_the_samples(drive, tmp_path):
    done = export_drive(drive, tmp_path / "drive.parquet", silent)
    assert [path.name for path in done.files][1:] == ["drive-poses.parquet", "drive-events.parquet"]
    poses = pq.read_table(done.files[1])
    assert poses["body"].to_pylist() == ["a", "b", "a"]
    assert poses["theta"].to_pylist() == [0.3, None, 0.4]
    events = pq.read_table(done.files[2])
    assert events["what"].to_pylist() == [event.what for event in drive.events]


def test_a_drive_without_poses_or_events_has_no_such_tables(single, tmp_path):
    done = export_drive(single, tmp_path / "drive.parquet", silent)
    assert "drive-poses.parquet" not in [path.name for path in done.files]


@given(rows=logs())
def test_a_frame_is_a_row(tmp_path_factory, rows):
    folder = tmp_path_factory.mktemp("frames")
    export_frames(written_log(folder / "can.log", rows), folder / "can.parquet", silent)
    table = pq.read_table(folder / "can.parquet").to_pylist()
    for seen, row in zip(table, rows, strict=True):
        assert (seen["time"], seen["channel"], seen["can_id"]) == (row.time, row.channel, row.can_id)
        assert (seen["data"], seen["length"]) == (row.data, row.length)
        flags = {"extended": EXTENDED, "remote": REMOTE, "error": ERROR, "fd": FD}
        assert all(seen[name] == bool(row.flags & bit) for name, bit in flags.items())


@pytest.mark.parametrize(
    ("name", "words"), [("a.pcap", "frames only"), ("a.xyz", r"no format .xyz; expected .asc, .blf")]
)
def test_a_drive_is_no_log_of_frames(drive, tmp_path, name, words):
    with pytest.raises(ExportError, match=words):
        export_drive(drive, tmp_path / name, silent)


def test_tum_has_no_frames(drive, tmp_path):
    with pytest.raises(ExportError, match="TUM holds trajectories"):
        export_frames(LogStream(tmp_path / "can.log"), tmp_path / "a.tum", silent)
    with pytest.raises(ExportError, match="leave --frames out"):
        export_drive(drive, tmp_path / "a.tum", silent, LogStream(tmp_path / "can.log"))
