"""The setting of a case: the same for the same seed, with faults of the sizes that the vocabulary states."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from studies.mismatch.engines.scene import Case, cases, scene
from studies.mismatch.engines.vocabulary import VOCABULARY

SINGLES = st.sampled_from(
    [(effect, component) for effect in VOCABULARY for component in VOCABULARY[effect].components]
)


@given(SINGLES, st.integers(0, 10**9))
def test_a_label_says_what_the_fault_is_within_the_bounds_of_the_vocabulary(single, seed):
    setting = scene(Case("single", (single,), "squares", "none"), seed)
    (label,), (fault,), own = setting.labels, setting.faults, VOCABULARY[single[0]]
    assert (label["effect"], label["component"]) == (fault.effect, fault.component) == single
    assert {name: value["value"] for name, value in label["parameters"].items()} == {
        name: value
        for name, value in fault.parameters.items()
        if name not in {"radius", "start", "intervals"}
    }
    sizes = np.abs(np.array(fault[own.parameter]) - (own.parameter == "ratio"))
    assert np.all((own.concealed[0] - 1e-12 <= sizes) & (sizes <= own.concealed[1] + 1e-12))
    assert len(str(int(setting.start))) == 10  # as in logs


@pytest.mark.parametrize("number", range(0, 62, 7))
def test_the_same_seed_gives_the_same_setting(number):
    case = cases(quick=True)[number]
    first, second = scene(case, 5), scene(case, 5)
    assert all(getattr(first, name) == getattr(second, name) for name in ("robot", "laps", "labels", "floor"))
    assert first.robot != scene(case, 6).robot


def test_a_drive_repeats_and_faults_do_not_remember_the_drive_before():
    setting = scene(Case("single", (("gear_backlash", "a.left"),), "shuttle", "none"), 3)
    first, second = setting.driven(setting.faults), setting.driven(setting.faults)
    assert np.array_equal(first.counts, second.counts)
    assert all(not fault.memory for fault in setting.faults)


def test_the_full_corpus_has_the_nulls_and_every_effect():
    whole = cases(quick=False)
    assert sum(case.kind == "null" for case in whole) >= 300
    singles = {effect for case in whole if case.kind == "single" for effect, _ in case.effects}
    assert singles == set(VOCABULARY)
