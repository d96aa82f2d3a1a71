"""The setting of a case: the same for the same seed, with faults of the sizes that the vocabulary states."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from studies.mismatch.engines.cases import Case, cases
from studies.mismatch.engines.scene import scene
from studies.mismatch.engines.vocabulary import VOCABULARY

SINGLES = st.sampled_from(
    [(effect, component) for effect in VOCABULARY for component in VOCABULARY[effect].components]
)
SEEDS = st.integers(0, 10**9)


def strength(effect, label):
    """Return the size of a concealed effect without its sign, of each event where there are several."""
    name = VOCABULARY[effect].parameter
    value = np.abs(np.atleast_1d(label["parameters"].get(name, {"value": np.nan})["value"]))
    return np.abs(value - 1.0) if VOCABULARY[effect].parameter == "ratio" else value


@given(SINGLES, SEEDS)
def test_labels_are_within_the_bounds_of_the_vocabulary(single, seed):
    setting = scene(Case("single", (single,), "squares", "none"), seed)
    (label,), ((low, high),) = setting.labels, (VOCABULARY[single[0]].concealed,)
    assert (label["effect"], label["component"]) == single
    sizes = strength(single[0], label)
    assert np.all((low - 1e-12 <= sizes) & (sizes <= high + 1e-12))


@given(SINGLES, SEEDS)
def test_a_label_says_what_the_fault_of_the_robot_is(single, seed):
    setting = scene(Case("single", (single,), "squares", "none"), seed)
    (label,), (fault,) = setting.labels, setting.faults
    assert (fault.effect, fault.component) == single
    assert {name: value["value"] for name, value in label["parameters"].items()} == {
        name: value
        for name, value in fault.parameters.items()
        if name not in {"radius", "start", "intervals"}
    }


@pytest.mark.parametrize("number", range(0, 62, 7))
def test_the_same_seed_gives_the_same_setting(number):
    case = cases(quick=True)[number]
    first, second = scene(case, 5), scene(case, 5)
    assert (first.robot, first.laps, first.labels, first.floor) == (
        second.robot,
        second.laps,
        second.labels,
        second.floor,
    )
    assert first.robot != scene(case, 6).robot


def test_a_drive_repeats_and_faults_do_not_remember_the_drive_before():
    setting = scene(Case("single", (("gear_backlash", "a.left"),), "shuttle", "none"), 3)
    first, second = setting.driven(setting.faults), setting.driven(setting.faults)
    assert np.array_equal(first.counts, second.counts)
    assert all(not fault.memory for fault in setting.faults)


@given(SEEDS)
def test_every_drive_starts_at_a_time_of_ten_digits(seed):
    setting = scene(Case("null", (), "squares", "none"), seed)
    assert len(str(int(setting.start))) == 10
