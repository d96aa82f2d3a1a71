"""The windows of the Husky come out as recordings, with the slip that they are known for."""

import numpy as np
import pytest

from omnimate.files.errors import SourceError
from omnimate.vehicle.odometry import dead_reckon
from omnimate.vehicle.se2 import wrap
from studies.datasets.husky import WINDOWS, each_recording


def test_every_window_is_a_recording_of_its_nominal_robot_that_slips(shared_data):
    recordings = dict(each_recording(shared_data / "real/drive_ugv")).values()
    assert len(recordings) == 603
    ends = []
    for recording in recordings:
        assert len(recording) == 40
        assert recording.present.all()
        assert not np.isnan(recording.commands).any()
        last = np.searchsorted(recording.time, recording.poses.time[-1] - 1e-6)
        ends.append(dead_reckon(recording)[last] - recording.poses.pose[-1])
    away = np.array(ends)
    assert np.sqrt(np.mean(np.sum(away[:, :2] ** 2, axis=1))) == pytest.approx(0.541, abs=0.005)
    assert np.sqrt(np.mean(wrap(away[:, 2]) ** 2)) == pytest.approx(1.475, abs=0.01)


def test_a_file_that_is_no_such_archive_is_refused(tmp_path):
    (tmp_path / WINDOWS).write_bytes(b"no archive")
    with pytest.raises(SourceError, match="cannot be read"):
        next(each_recording(tmp_path))


def test_arrays_that_do_not_fit_each_other_are_refused(tmp_path):
    names = ["cmd_left", "cmd_right", "left_wheel_vel", "right_wheel_vel", "icp_x", "icp_y", "icp_yaw"]
    arrays = {name: np.zeros((2, 40)) for name in names} | {"cmd_left": np.zeros((2, 39))}
    np.savez(tmp_path / WINDOWS, **arrays)
    with pytest.raises(SourceError, match="cmd_left of shape"):
        next(each_recording(tmp_path))
