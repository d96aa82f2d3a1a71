"""What is wrong with poses or runs costs no accuracy, or is named."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from omnimate.calib.errors import CalibrationError
from omnimate.calib.paths.drives import Drive
from omnimate.calib.paths.kinematics import Differential
from omnimate.calib.paths.least_squares import PathCalibration, calibrate_path
from studies.datasets.optiodom.drives import read_set
from tests.calib.paths.test_least_squares import NOMINAL, TRUE, dense_drive, wandering

OTHER = TRUE + np.array([0.05, 0.0, 0.004])  # a robot whose wheelbase is 5 % larger
SEEDS = range(4)
Spoil = Callable[[list[Drive]], list[Drive]]


def runs(seed: int, true: np.ndarray = TRUE) -> list[Drive]:
    """Return six runs of a minute with a pose every 2 s."""
    return [
        dense_drive(Differential(NOMINAL), true, wandering(60.0, 10 * seed + run), seed=run, every=40)
        for run in range(6)
    ]


def calibrate(drives: Sequence[Drive]) -> PathCalibration:
    return calibrate_path(drives, Differential(NOMINAL))


def scattered(share: float) -> Spoil:
    """Return what moves a share of all poses by half a metre and half a radian."""

    def spoil(drives: list[Drive]) -> list[Drive]:
        chance = np.random.default_rng(7)
        return [
            replace(
                drive,
                pose=drive.pose
                + (chance.random(len(drive.pose)) < share)[:, np.newaxis]
                * chance.normal(0.0, 0.5, drive.pose.shape),
            )
            for drive in drives
        ]

    return spoil


def swapped(drive: Drive) -> Drive:
    return replace(drive, readings=drive.readings[:, ::-1])


def late(drive: Drive) -> Drive:
    return replace(drive, fix_time=drive.fix_time + 1.0)


def excursion(drive: Drive) -> Drive:
    pose = drive.pose.copy()
    pose[12:19, :2] += 0.2 * np.sin(np.linspace(0.3, 2.8, 7))[:, np.newaxis]
    return replace(drive, pose=pose)


def third(change: Callable[[Drive], Drive]) -> Spoil:
    return lambda drives: [*drives[:2], change(drives[2]), *drives[3:]]


def error(calibrations: Sequence[PathCalibration]) -> np.ndarray:
    """Return the root mean square error of the coordinates over experiments."""
    errors = [found.estimate.coordinates - TRUE for found in calibrations]
    return np.asarray(np.sqrt(np.mean(np.square(errors), axis=0)))


@pytest.fixture(scope="module")
def clean() -> list[PathCalibration]:
    return [calibrate(runs(seed)) for seed in SEEDS]


def test_nothing_is_left_out_of_clean_runs(clean: list[PathCalibration]) -> None:
    assert [(found.left_out, found.estimate.down_weighted) for found in clean] == [((), ())] * len(clean)


@pytest.mark.parametrize("share", [0.01, 0.1, 0.3])
def test_outliers_among_the_poses_cost_a_fifth_of_the_accuracy_at_most(
    clean: list[PathCalibration], share: float
) -> None:
    found = [calibrate(scattered(share)(runs(seed))) for seed in SEEDS]
    assert np.linalg.norm(error(found)) < 1.2 * np.linalg.norm(error(clean))
    assert not any(one.left_out for one in found)


@pytest.mark.parametrize(
    ("change", "cause"),
    [(swapped, "the left and the right wheel are swapped"), (late, "1.0 s ahead"), (excursion, "")],
    ids=["swapped", "late", "excursion"],
)
def test_a_run_that_does_not_fit_does_no_harm_and_is_named(
    clean: list[PathCalibration], change: Callable[[Drive], Drive], cause: str
) -> None:
    found = [calibrate(third(change)(runs(seed))) for seed in SEEDS]
    assert np.linalg.norm(error(found)) < 1.2 * np.linalg.norm(error(clean))
    for one in found:
        sentence = " ".join(map(str, (*one.left_out, *one.estimate.down_weighted)))
        assert "seed 2" in sentence
        assert cause in sentence


def test_a_run_of_another_robot_is_named_and_left_out(clean: list[PathCalibration]) -> None:
    found = [calibrate([*runs(seed)[:2], runs(seed, OTHER)[2], *runs(seed)[3:]]) for seed in SEEDS]
    assert all("seed 2 is left out" in str(*one.left_out) for one in found)
    assert np.linalg.norm(error(found)) < 1.2 * np.linalg.norm(error(clean))


@pytest.mark.parametrize(
    ("change", "cause"), [(swapped, "wheel are swapped"), (late, "clock of the poses .*--time-offset")]
)
def test_an_error_of_all_runs_is_named(change: Callable[[Drive], Drive], cause: str) -> None:
    with pytest.raises(CalibrationError, match=cause):
        calibrate([change(drive) for drive in runs(0)])


def test_poses_that_mostly_contradict_the_wheels_are_no_calibration() -> None:
    chance = np.random.default_rng(1)
    drive = runs(0)[0]
    with pytest.raises(CalibrationError, match=r"do not fit the wheels|does not converge"):
        calibrate([replace(drive, pose=drive.pose + chance.normal(0.0, 0.5, drive.pose.shape))])


def test_a_public_set_with_a_wrong_first_heading_is_calibrated(shared_data: Path) -> None:
    """OptiOdom's square 231220200029, whose authors calibrate from it: Sousa et al. (2022)."""
    folder = shared_data / "real/optiodom_outlier/diff/square/231220200029"
    if not folder.is_dir():
        pytest.skip("the data set is not here")
    data = read_set(folder)
    found = calibrate_path(data.drives, data.kinematics)
    (outlier,) = found.estimate.down_weighted
    assert (outlier.source[-13:], outlier.time) == ("run-02.csv.gz", 0.0)
    assert found.quantities[0].value == pytest.approx(0.2014, abs=0.0004)  # [m], as without this run
