"""The quick question: how often a healthy robot is called one that is not, what is seen, and where."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.files.recordings.folder import load_recording
from omnimate.mismatch.diagnosis import Where
from omnimate.mismatch.recording.signals import WINDOW
from omnimate.mismatch.triage import SAMPLES, _says, thinned, triage
from studies.mismatch.engines.wide.cases import KINDS, make
from tests.mismatch.conftest import cut

HEALTHY = 20
WIDE = 8  # healthy robots of the wide world


@pytest.fixture(scope="module")
def wide(tmp_path_factory):
    """Return recordings of healthy robots from wide distributions, whose poses are in time."""
    found, number = [], 0
    while len(found) < WIDE:
        folder = tmp_path_factory.mktemp("wide") / str(number)
        chance = np.random.default_rng([2, number, 5])  # as `make` draws the kind of a case
        if chance.choice(list(KINDS), p=list(KINDS.values())) == "null":
            label = make(folder, 2, number)
            if not any(each["effect"] == "latency" for each in label["secondary"]):
                found.append(load_recording(folder / "1"))
        number += 1
    return found


def test_a_healthy_robot_is_called_one_that_is_not_once_in_a_hundred_drives(drive):
    """The declared rate is 1 %: of twenty drives three alarms have a probability of one in a thousand."""
    verdicts = [triage([drive(seed=seed)]).verdict for seed in range(HEALTHY)]
    assert verdicts.count("mismatch") <= 2


@pytest.mark.slow
def test_in_the_wide_world_it_gives_no_more_false_alarms_than_the_whole_diagnosis(wide):
    """That one calls a fifth of these robots ill; five of eight by chance have a probability of 1 %."""
    verdicts = [triage([single]).verdict for single in wide]
    assert verdicts.count("mismatch") <= 4


@pytest.mark.parametrize(
    ("name", "component", "values"),
    [
        ("wheel_diameter", "a.left", {"ratio": 1.004}),
        ("wheelbase", "b", {"ratio": 1.01}),
        ("joint_bias", "joint_a", {"bias": 0.01}),
        ("bump", "b.right", {"times": (20.0,), "lost": (0.01,)}),
        ("slip_patch", "a.left", {"intervals": ((20.0, 26.0),), "fraction": 0.05}),
        ("latency", "a.left", {"delay": 0.5}),
    ],
)
def test_what_stands_far_above_the_noise_is_seen(drive, effect, name, component, values):
    answer = triage([drive(effect(name, component, **values))])
    assert answer.verdict == "mismatch"
    assert answer.probability > 0.99


def test_what_acts_at_a_moment_is_found_in_its_block_of_time(drive, effect):
    answer = triage([drive(effect("bump", "b.right", times=(20.0,), lost=(0.01,)))])
    assert any(start <= 21.0 and end >= 20.0 for start, end in answer.where.intervals)
    assert sum(end - start for start, end in answer.where.intervals) < 20.0


def test_what_acts_all_the_time_comes_with_its_name_and_signals(drive, effect):
    answer = triage([drive(effect("joint_bias", "joint_a", bias=0.01), laps=3)])
    assert (answer.closest[0].effect, answer.closest[0].component) == ("joint_bias", "joint_a")
    assert set(answer.where.channels) & {"joint_a", "link"}


def test_the_sentence_names_few_intervals_and_counts_the_others():
    intervals = tuple((10.0 * number, 10.0 * number + 2.0) for number in range(107))
    sentence = _says(Where(("a.left",), intervals), ())
    assert "at 0.0 to 2.0 s, 10.0 to 12.0 s, " in sentence
    assert "40.0 to 42.0 s and 102 more times. No single effect" in sentence


def test_a_drive_that_is_too_short_is_insufficient(drive):
    assert triage([cut(drive(), slice(0, 400))]).verdict == "insufficient"


def test_thinning_takes_the_samples_that_lack_least(drive):
    whole = drive()
    present = whole.present.copy()
    present[::2] = False  # every other SYNC was not answered
    few = thinned(replace(whole, present=present))
    assert few.present.all()
    assert np.all(np.isin(few.time, whole.time))
    assert np.median(np.diff(few.time)) <= WINDOW / SAMPLES * 1.01


def test_a_recording_with_few_samples_stays_as_it_is(drive):
    few = thinned(drive())
    assert thinned(few) is few
