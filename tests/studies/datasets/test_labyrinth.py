"""The Labyrinth data come out as their readme describes them: with the error that is known to be in it."""

import shutil

import numpy as np
import pytest

from omnimate.files.errors import SourceError
from omnimate.vehicle.arcs import arc, integrate
from omnimate.vehicle.odometry import truck_travel
from studies.datasets.labyrinth import INPUT, each_recording


def away(recording, left, right, wheelbase):
    """Return the distance of odometry from the truth after the best rigid alignment, rms [m]."""
    path = integrate(arc(np.diff(left), np.diff(right), wheelbase)) @ np.array([1.0, 1.0j, 0.0])
    truth = recording.poses.pose[:, :2] @ np.array([1.0, 1.0j])
    path, truth = path - path.mean(), truth - truth.mean()
    turn = np.angle(np.sum(truth * np.conj(path)))
    return float(np.sqrt(np.mean(np.abs(path * np.exp(1j * turn) - truth) ** 2)))


def test_as_documented_it_is_far_off_and_with_swapped_wheels_and_twice_the_track_it_is_near(shared_data):
    ((_, recording),) = each_recording(shared_data / "real/labyrinth_tuc")
    left, right, _ = truck_travel(recording, "a")
    assert recording.vehicle.trucks["a"].wheelbase == 0.0785
    assert away(recording, left, right, 0.0785) == pytest.approx(0.906, abs=0.005)
    assert away(recording, right, left, 0.155) == pytest.approx(0.046, abs=0.005)


def test_positions_have_no_heading_and_every_sample_is_there(shared_data):
    ((_, recording),) = each_recording(shared_data / "real/labyrinth_tuc")
    assert len(recording) == len(recording.poses.time) == 233
    assert recording.present.all()
    assert np.isnan(recording.poses.pose[:, 2]).all()


def test_a_damaged_line_is_named(shared_data, tmp_path):
    folder = tmp_path / "labyrinth"
    shutil.copytree(shared_data / "real/labyrinth_tuc", folder)
    path = folder / INPUT
    lines = path.read_text().splitlines()
    place = next(number for number, line in enumerate(lines) if line.startswith("odom2diff"))
    lines[place] = "odom2diff 0.1 nan"
    path.write_text("\n".join(lines))
    with pytest.raises(SourceError, match=rf"{INPUT}:{place + 1}: expected 8 finite numbers"):
        next(each_recording(folder))


def test_a_folder_without_the_files_is_refused(tmp_path):
    with pytest.raises(SourceError, match="cannot be read"):
        next(each_recording(tmp_path))
