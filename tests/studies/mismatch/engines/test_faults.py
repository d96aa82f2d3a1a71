"""The faults: one of no strength changes nothing, and one of some strength changes the recording."""

from dataclasses import replace

import numpy as np
import pytest

from studies.mismatch.engines.scene import Case, drawn_parameters, scene
from studies.mismatch.engines.vocabulary import UNNAMED, VOCABULARY

PLACES = [
    (effect, place)
    for effect, own in VOCABULARY.items()
    for place in dict.fromkeys((own.components[0], own.components[-1]))
]


def driven(case, laps=slice(None)):
    """Return a healthy robot with some laps of a programme, and its drive."""
    setting = scene(case, 11)
    setting = replace(setting, laps=setting.laps[laps])
    return setting, setting.driven([])


@pytest.fixture(scope="module")
def leg():
    """Return a robot and its drive along one side of a square."""
    return driven(Case("null", (), "squares", "none", note="short"))


@pytest.fixture(scope="module")
def shuttle():
    """Return a robot and its drive to and fro."""
    return driven(Case("null", (), "shuttle", "none"), slice(1, 2))  # the fast lap


def changes(robot, effect, component, parameters):
    setting, healthy = robot
    faulty = setting.driven([setting.fault(effect, component, parameters)])
    return not (np.array_equal(healthy.counts, faulty.counts) and np.array_equal(healthy.poses, faulty.poses))


def drawn(robot, effect):
    time = robot[1].time
    return drawn_parameters(np.random.default_rng(2), effect, time[0], time[-1] - time[0], "")


@pytest.mark.parametrize(("effect", "component"), PLACES)
def test_a_fault_of_no_strength_changes_nothing(effect, component, leg):
    parameters = drawn(leg, effect)
    assert not changes(leg, effect, component, VOCABULARY[effect].sized(0.0, parameters))


@pytest.mark.parametrize("kind", UNNAMED)
def test_physics_without_a_name_and_without_strength_changes_nothing(kind, leg):
    parameters = {"kind": kind, "size": 0.0, "pitch": 1.0, "times": [leg[0].start + 3.0]}
    assert not changes(leg, "unknown", UNNAMED[kind][0], parameters)


@pytest.mark.parametrize("effect", VOCABULARY)
def test_a_fault_of_the_size_of_the_corpus_changes_the_recording(effect, shuttle):
    assert changes(shuttle, effect, VOCABULARY[effect].components[0], drawn(shuttle, effect))
