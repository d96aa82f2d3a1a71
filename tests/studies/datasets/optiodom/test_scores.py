"""The real robots: calibrated on the squares, scored on drives that the fit has not seen."""

import gzip

import numpy as np
import pytest

from omnimate.vehicle.arcs import integrate
from studies.datasets.optiodom.drives import OptiOdomError, Tricycle, find_sets, read_set
from studies.datasets.optiodom.scores import score_optiodom


@pytest.fixture(scope="module")
def robots(shared_data):
    return {one.kind: one for one in score_optiodom(shared_data / "real" / "optiodom")}


def rms(robot, path, which):
    return [getattr(one, which).rms for one in robot.sets if one.name.split("/")[1] == path]


def test_the_raw_figure_of_the_free_drive_is_that_of_the_data(robots):
    assert rms(robots["diff"], "free", "raw") == [pytest.approx(0.122, abs=5e-4)]


def test_least_squares_beat_the_printed_equations_on_what_neither_has_seen(robots):
    """29 mm have been reached on the free drive with the printed equations."""
    robot = robots["diff"]
    assert rms(robot, "free", "fitted")[0] < 0.029
    for path in ("free", "circular"):
        printed, fitted = rms(robot, path, "printed"), rms(robot, path, "fitted")
        assert all(one < other for one, other in zip(fitted, printed, strict=True))


def test_tricycles_are_eight_times_better_on_drives_that_the_fit_has_not_seen(robots):
    robot = robots["tricyc"]
    assert np.sqrt(np.mean(np.square(rms(robot, "free", "fitted")))) < 0.056
    assert np.mean(rms(robot, "circular", "raw")) > 0.56
    assert np.mean(rms(robot, "circular", "fitted")) < 0.075


def test_markers_placed_by_the_squares_are_nearer_on_drives_that_the_fit_has_not_seen(robots):
    """The same thing is compared then: where the markers are, not where the axle's middle is."""
    for path in ("free", "circular"):
        rows = {which: rms(robots["tricyc"], path, which) for which in ("fitted", "placed")}
        assert np.mean(rows["placed"]) < 0.9 * np.mean(rows["fitted"])


def test_only_squares_are_seen(robots):
    for robot in robots.values():
        assert all(one.seen == (one.name.split("/")[1] == "square") for one in robot.sets)


def metadata(kind="tricyc"):
    return f"type,{kind},\nngear,1,\nencRes,1600,\nLi,0.15,\nDi,0.065,\nThi,0,\nN,1,\n"


def write_set(folder, rows, text=None):
    folder.mkdir(parents=True)
    (folder / "x_metadata.csv").write_text(metadata() if text is None else text, encoding="utf-8")
    with gzip.open(folder / "x_run-01.csv.gz", "wt") as file:
        np.savetxt(file, rows, delimiter=",")


def made_up_rows(steering=0.3):
    """A tricycle on a circle, whose ticks lead to the pose of their row."""
    ticks = np.full(200, 20.0)
    ticks[0] = 0.0
    readings = np.stack([np.cumsum(ticks) * 2.0 * np.pi / 1600.0, np.full(200, steering)], axis=-1)
    path = integrate(Tricycle(0.15, 0.065).steps(readings, np.zeros(3)).increment)
    return np.column_stack([0.05 * np.arange(200), path, ticks, np.full(200, steering)])


def test_a_tricycle_set_is_read_as_its_readings_and_poses(tmp_path):
    write_set(tmp_path / "tricyc" / "square" / "1", made_up_rows())
    data = read_set(tmp_path / "tricyc" / "square" / "1")
    assert (data.name, data.robot, data.path) == ("tricyc/square/1", "tricyc", "square")
    assert data.kinematics == Tricycle(0.15, 0.065)
    (drive,) = data.drives
    assert drive.readings[-1, 0] == pytest.approx(199 * 20 * 2.0 * np.pi / 1600.0)


def test_a_perfect_robot_scores_zero_with_any_parameters_that_are_its_own(tmp_path):
    write_set(tmp_path / "tricyc" / "square" / "1", made_up_rows())
    turns = made_up_rows(-0.2)
    write_set(tmp_path / "tricyc" / "free" / "2", turns)
    (robot,) = score_optiodom(tmp_path)
    assert all(one.raw.rms < 1e-9 for one in robot.sets)
    assert robot.printed is None


@pytest.mark.parametrize(
    ("text", "words"),
    [(metadata("quad"), "expected diff or tricyc"), (metadata().replace("Li,0.15", "Li,x"), "metadata Li")],
)
def test_metadata_of_no_robot_are_refused(tmp_path, text, words):
    write_set(tmp_path / "set", made_up_rows(), text)
    with pytest.raises(OptiOdomError, match=words):
        read_set(tmp_path / "set")


def test_folders_without_sets_runs_or_squares_are_refused(tmp_path):
    with pytest.raises(OptiOdomError, match="no \\*_metadata"):
        find_sets(tmp_path)
    write_set(tmp_path / "tricyc" / "free" / "1", made_up_rows())
    with pytest.raises(OptiOdomError, match="needs squares"):
        score_optiodom(tmp_path)
    (tmp_path / "tricyc" / "free" / "1" / "x_run-01.csv.gz").unlink()
    with pytest.raises(OptiOdomError, match="no \\*_run"):
        read_set(tmp_path / "tricyc" / "free" / "1")
