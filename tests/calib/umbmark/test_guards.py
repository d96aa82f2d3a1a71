"""Guards speak up when something is wrong, and hold their tongue when nothing is."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from omnimate.calib.umbmark.experiment import Experiment
from omnimate.calib.umbmark.guards import advise, without_outliers
from omnimate.calib.umbmark.return_errors import ReturnErrors
from studies.papers.trials import Trial, floor_covariance, plain_covariance

TRIAL = Trial(0.98874, 1.00084, floor_covariance(0.025) + plain_covariance(0.002, 0.007))


def spoiled(spoil: Callable[[np.ndarray, np.ndarray], None], side: float = 4.0, seed: int = 3) -> Experiment:
    experiment = TRIAL.drive(np.random.default_rng(seed))
    cw, ccw = experiment.errors.cw.copy(), experiment.errors.ccw.copy()
    spoil(cw, ccw)
    return replace(experiment, errors=ReturnErrors(cw, ccw, side))


def scaled(factor: float) -> Callable[[np.ndarray, np.ndarray], None]:
    def spoil(cw: np.ndarray, ccw: np.ndarray) -> None:
        cw[:, 2] *= factor
        ccw[:, 2] *= factor

    return spoil


def without_last_turn(cw: np.ndarray, ccw: np.ndarray) -> None:
    cw[:, 2] += np.pi / 2
    ccw[:, 2] -= np.pi / 2


def with_outlier(cw: np.ndarray, ccw: np.ndarray) -> None:
    cw[2, :2] += [0.4, -0.2]


def off_diagonal(cw: np.ndarray, ccw: np.ndarray) -> None:
    cw[:, 0] += 0.2
    ccw[:, 0] -= 0.2


@pytest.mark.parametrize(
    ("factors", "runs"), [((0.98874, 1.00084), 5), ((1.0, 1.0), 5), ((0.95, 1.005), 3), ((1.0, 1.0), 2)]
)
def test_healthy_data_raise_no_alarm(factors: tuple[float, float], runs: int) -> None:
    """Three guards at 1 in 1000 each: at most 1 % of 300 experiments, whatever the robot's errors are."""
    trial = replace(TRIAL, e_b=factors[0], e_d=factors[1], runs=runs)
    chance = np.random.default_rng(11)
    drives = [trial.drive(chance) for _ in range(300)]
    assert sum(bool(advise(drive) or without_outliers(drive)[1]) for drive in drives) <= 3


@pytest.mark.parametrize(
    ("experiment", "severity", "words"),
    [
        (spoiled(scaled(57.3)), "error", "degrees stand where radians"),
        (spoiled(scaled(1 / 57.3)), "error", "radians stand where degrees"),
        (spoiled(scaled(-1.0)), "error", "wrong sign"),
        (spoiled(without_last_turn), "error", "last turn is missing"),
        (spoiled(lambda _cw, _ccw: None, side=16.0), "error", "the side is the whole path"),
        (spoiled(off_diagonal), "warning", "off their diagonals"),
    ],
)
def test_what_is_wrong_is_named(experiment: Experiment, severity: str, words: str) -> None:
    """Each with what to do about it, and once."""
    found = [one for one in advise(experiment) if words in str(one)]
    assert [one.severity for one in found] == [severity]
    assert found[0].do


def test_few_runs_are_an_error_or_a_warning() -> None:
    """1 + 1 runs have no scatter; 1 + 5 borrow it from the other direction."""
    errors = TRIAL.drive(np.random.default_rng(1)).errors
    alone = replace(
        TRIAL.drive(np.random.default_rng(1)),
        errors=replace(errors, cw=errors.cw[:1].copy(), ccw=errors.ccw[:1].copy()),
    )
    lopsided = replace(alone, errors=replace(errors, cw=errors.cw[:1].copy()))
    assert [(one.severity, "n = 1" in one.what) for one in advise(alone)] == [("error", True)]
    assert [(one.severity, "n = 1" in one.what) for one in advise(lopsided)] == [("warning", True)]


def test_headings_that_contradict_few_runs_are_told_by_their_size() -> None:
    """Two runs each way hardly know their scatter; headings 11 degrees off are wrong all the same."""
    two = replace(TRIAL, runs=2).drive(np.random.default_rng(2))
    wrong = replace(two, errors=replace(two.errors, cw=np.add(two.errors.cw, [0.0, 0.0, 0.2])))
    assert any("headings" in one.what for one in advise(wrong))


@pytest.mark.parametrize("theta", [1.0, np.nan], ids=["headings", "no headings"])
def test_a_run_far_from_the_others_is_left_out_and_named(theta: float) -> None:
    """Also in a table without theta; the rest is the experiment as if it had not been driven."""
    clean, wild = spoiled(lambda _cw, _ccw: None), spoiled(with_outlier)
    errors = wild.errors
    blind = replace(errors, cw=errors.cw * [1, 1, theta], ccw=errors.ccw * [1, 1, theta])
    rest, (advice,) = without_outliers(replace(wild, errors=blind))
    assert str(advice).startswith("cw run 3 is left out")
    np.testing.assert_array_equal(rest.errors.cw[:, :2], np.delete(clean.errors.cw, 2, axis=0)[:, :2])
    assert without_outliers(clean) == (clean, ())


def test_return_errors_above_the_side_are_asked_about_and_not_refused() -> None:
    """They are true of very different wheels, and of a wrong unit."""
    true = Trial(0.85, 1.02, floor_covariance(0.02)).drive(np.random.default_rng(2))
    assert true.errors.e_max_syst > 4.0
    asked = [advice for advice in advise(true) if "unit" in advice.what]
    assert [advice.severity for advice in asked] == ["warning"]
    assert not any("unit right" in advice.what for advice in advise(spoiled(lambda cw, ccw: None)))
