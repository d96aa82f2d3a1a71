"""Obstacles that are met many times: under which wheel, when, and how much way they take."""

import numpy as np
import pytest

from omnimate.mismatch import diagnose
from omnimate.mismatch.candidates.pushes import Push
from omnimate.mismatch.candidates.regression import Regression
from omnimate.mismatch.candidates.terms import smooth_terms
from omnimate.mismatch.investigate import startup_nuisances, whiten_with_estimated_noise
from omnimate.mismatch.recording.signals import WINDOW, signals_of
from omnimate.mismatch.recording.windows import windows_of
from omnimate.mismatch.scans.obstacles import LOST, MIN_ENCOUNTERS, find_obstacles, train
from tests.mismatch.conftest import USUAL

TIMES = tuple(np.arange(10.0, 82.0, 8.0).tolist())
TAKEN = 4e-3  # [m] that each obstacle takes
ASIDE, ROUND = 2e-3, 8e-3  # [m, rad] by which it shakes the truck to one side, and back


def shaken_from(effect, start):
    """Return obstacles that also shake their truck to and fro, in a drive that starts at a time [s]."""
    times = tuple(start + time for time in TIMES)
    return (
        effect("bump", "a.left", times=times, lost=(TAKEN,) * len(times)),
        *(Push("a", time, 2.0 * WINDOW, ((0.0, ASIDE, ROUND), (0.0, -ASIDE, -ROUND))) for time in times),
    )


@pytest.fixture(scope="module")
def shaking(effect):
    return shaken_from(effect, 0.0)


def obstacles_of(*recordings):
    """Return the obstacles of recordings of one robot."""
    signals = [signals_of(recording) for recording in recordings]
    own = Regression([windows_of(single) for single in signals], USUAL, ())
    own.add(startup_nuisances(smooth_terms(signals), signals))
    return find_obstacles(whiten_with_estimated_noise(own))


@pytest.fixture(scope="module")
def met(drive):
    """Return a function that finds the obstacles of a drive with effects."""
    return lambda *effects: obstacles_of(drive(*effects))


@pytest.mark.slow
def test_obstacles_are_found_by_what_they_leave_behind_however_they_shake_the_truck(met, shaking):
    found = met(*shaking)
    assert [term.component for term in found.terms] == ["a.left"]
    (term,) = found.terms
    assert len(term.fixed["times"]) == len(TIMES)
    np.testing.assert_allclose(term.fixed["times"], TIMES, atol=2.0 * WINDOW)
    effect = term.built(found.values[0])
    assert np.mean(effect.lost) == pytest.approx(TAKEN, rel=0.1)
    assert term.odds > 20.0


def test_where_obstacles_are_both_trucks_are_shaken_and_nowhere_else(met, shaking):
    (pushes,) = met(*shaking).disturbances
    shaken = np.flatnonzero(np.einsum("mii->m", pushes) > 0.0)
    assert len(TIMES) <= len(shaken) < 8 * len(TIMES)
    assert np.all(pushes[shaken][:, range(6), range(6)] > 0.0)


@pytest.mark.parametrize(
    ("name", "component", "values"),
    [
        ("joint_backlash", "joint_b", {"width": 0.02}),
        ("gear_backlash", "a.left", {"width": 3e-3}),
        ("wheel_eccentricity", "b.left", {"amplitude": 1e-3}),
        (
            "slip_patch",
            "a.right",
            {"fraction": 0.05, "intervals": tuple((time, time + 2.0) for time in TIMES)},
        ),
    ],
)
def test_what_is_no_obstacle_is_none_however_often_it_happens(met, effect, name, component, values):
    assert met(effect(name, component, **values)).terms == []


@pytest.mark.slow
def test_obstacles_in_several_recordings_are_found_together(drive, effect):
    found = obstacles_of(*(drive(*shaken_from(effect, start), start_time=start) for start in (0.0, 1000.0)))
    assert [term.component for term in found.terms] == ["a.left"]
    assert all(np.any(pushes > 0.0) for pushes in found.disturbances)


def test_a_quiet_drive_meets_none_and_is_not_shaken(met):
    found = met()
    assert found.terms == []
    assert not found.disturbances[0].any()


def test_fewer_are_left_to_the_search(met, effect):
    few = TIMES[: MIN_ENCOUNTERS - 1]
    assert met(effect("bump", "a.left", times=few, lost=(TAKEN,) * len(few))).terms == []


def test_the_size_of_all_obstacles_is_held_and_each_takes_its_share():
    term = train("b.right", (1.0, 2.0), (0.5, 1.5), 2.0, 3.0)
    assert term.held == 2.0
    assert len(term.probes) == 1
    assert term.built(np.array([2.0])).lost == pytest.approx((LOST, 3.0 * LOST))
    assert term.at(times=(1.0, 3.0)).fixed["times"] == (1.0, 3.0)


def test_the_answer_names_the_obstacles_and_nothing_that_they_shake(drive, shaking):
    answer = diagnose([drive(*shaking)])
    assert [finding.key for finding in answer.findings] == [("bump", "a.left")]
    assert answer.findings[0].probability > 0.9
    lost = next(each for each in answer.findings[0].parameters if each.name == "lost")
    assert np.mean(lost.value) == pytest.approx(TAKEN, rel=0.1)


@pytest.mark.slow
def test_obstacles_are_not_named_where_bumps_are_left_out_of_the_library(drive, shaking):
    answer = diagnose([drive(*shaking)], without=["bump"])
    assert "bump" not in {finding.effect for finding in answer.findings}
