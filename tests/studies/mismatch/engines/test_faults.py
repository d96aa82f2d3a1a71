"""The faults: one of no strength changes nothing, and one of some strength changes the recording."""

import numpy as np
import pytest

from studies.mismatch.engines.cases import Case
from studies.mismatch.engines.scene import scene
from studies.mismatch.engines.vocabulary import UNNAMED, VOCABULARY

SEED = 11
PLACES = [
    (effect, component)
    for effect in VOCABULARY
    for component in (VOCABULARY[effect].components[0], VOCABULARY[effect].components[-1])
]


def setting_of(effect, component, drive="squares", note="short"):
    return scene(Case("single", ((effect, component),), drive, "none", note=note), SEED)


@pytest.mark.parametrize(("effect", "component"), PLACES)
def test_a_fault_of_no_strength_changes_nothing(effect, component):
    setting = setting_of(effect, component)
    own, (fault,) = VOCABULARY[effect], setting.faults
    unchanged(setting, effect, component, {**fault.parameters, **own.sized(0.0, fault.parameters)})


@pytest.mark.parametrize("kind", UNNAMED)
def test_physics_without_a_name_and_without_strength_changes_nothing(kind):
    setting = scene(Case("null", (), "squares", "none", note="short"), SEED)
    parameters = {"kind": kind, "size": 0.0, "pitch": 1.0, "times": [setting.start + 3.0]}
    unchanged(setting, "unknown", UNNAMED[kind][0], parameters)


def unchanged(setting, effect, component, parameters):
    healthy = setting.driven([])
    driven = setting.driven([setting.fault(effect, component, parameters)])
    assert np.array_equal(healthy.counts, driven.counts)
    assert np.array_equal(healthy.poses, driven.poses)


@pytest.fixture(scope="module")
def shuttle():
    """The robot of the seed, and its drive without a fault."""
    setting = scene(Case("null", (), "shuttle", "none"), SEED)
    return setting, setting.driven([])


@pytest.mark.parametrize("effect", VOCABULARY)
def test_a_fault_of_the_size_of_the_corpus_changes_the_recording(effect, shuttle):
    setting, healthy = shuttle
    faulty = setting_of(effect, VOCABULARY[effect].components[0], drive="shuttle", note="")
    assert (faulty.robot, faulty.laps) == (setting.robot, setting.laps)
    driven = setting.driven(faulty.faults)
    same = np.array_equal(healthy.counts, driven.counts) and np.array_equal(healthy.poses, driven.poses)
    assert not same
