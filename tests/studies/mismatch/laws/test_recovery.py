"""Laws in the place of effects: two drives of one robot, what is recovered, and how it is told."""

import numpy as np
import pytest

from studies.figures import plot_recovery
from studies.mismatch.engines.scene import Case
from studies.mismatch.laws.baselines import gaussian_process, has_sindy, sindy
from studies.mismatch.laws.study import LAW, METHODS, QUICK, pair, recovered_from, shares, table, wanted


@pytest.fixture(scope="module")
def drives(tmp_path_factory):
    """Return two drives of a robot with one truck, whose wheelbase is another."""
    case = Case("single", (("wheelbase", "a"),), "eights", "mocap", trucks=1)
    return pair(tmp_path_factory.mktemp("drives"), case, 5)


def test_two_drives_are_of_one_robot_with_the_effect_and_scatter_anew(drives):
    assert drives.effect.name == "wheelbase"
    assert drives.seen.vehicle == drives.unseen.vehicle
    assert np.any(drives.seen.poses.pose != drives.unseen.poses.pose)


@pytest.mark.slow
def test_a_law_recovers_four_fifths_of_what_the_effect_itself_explains_on_an_unseen_drive(drives):
    found = recovered_from(drives)
    assert found["gain"] > 30.0
    assert found["gains"][LAW] >= 0.8 * found["gain"]
    assert 'name = "law"' in found["law"]
    assert set(found["gains"]) == {name for name in METHODS if name != "pysindy" or has_sindy()}


def test_the_small_study_has_some_effects_and_the_whole_one_all_that_the_corpus_has():
    assert {case.effects[0][0] for case, _ in wanted(1, 1, quick=True)} == set(QUICK)
    every = [case.effects[0][0] for case, _ in wanted(2, 1)]
    assert len(every) == 2 * len(set(every)) == 48


@pytest.mark.parametrize("method", [gaussian_process, sindy])
def test_a_baseline_finds_a_line_in_speed_and_predicts_it_on_another_drive(method):
    if method is sindy and not has_sindy():
        pytest.skip("pysindy is not installed (pip install omnimate[laws])")
    chance = np.random.default_rng(3)
    seen, unseen = ({"speed": chance.uniform(-1.0, 1.0, 400)} for _ in range(2))
    rows = 5.0 * seen["speed"] + chance.standard_normal(400)
    learned = method(seen, lambda basis: 1e3 * basis, rows, np.arange(400) // 50, 2e-3)
    assert np.abs(1e3 * learned(unseen) - 5.0 * unseen["speed"]).mean() < 0.5


RESULTS = [
    {"effect": name, "component": "a", "gain": gain, "gains": {"law": law, "pysindy": other}, "law": ""}
    for name, gain, law, other in (("wheelbase", 100.0, 90.0, -5.0), ("bump", 50.0, 0.0, 10.0))
]


def test_the_table_counts_what_is_enough_and_what_is_worse_than_nothing():
    assert shares(RESULTS) == {"law": [0.9, 0.0], "pysindy": [-0.05, 0.2]}
    columns = [list(column.cells) for column in table(RESULTS).columns]
    assert columns[0] == ["wheelbase", "bump", "all"]
    assert columns[3] == ["1/1", "0/1", "1/2"]
    assert columns[7] == ["1", "0", "1"]


def test_the_figure_is_drawn_with_two_methods(tmp_path):
    plot_recovery({one["effect"]: shares([one]) for one in RESULTS}, 0.8, tmp_path / "laws.svg")
    assert "pysindy" in (tmp_path / "laws.svg").read_text()
