"""What is the same in all recordings of a robot is said to repeat, and what differs is said to differ."""

from dataclasses import replace

import numpy as np

from omnimate.mismatch import diagnose
from omnimate.mismatch.answer.repeats import repeats_of
from omnimate.mismatch.candidates.terms import term
from tests.mismatch.conftest import fit_of


def repeats(recordings):
    return repeats_of(fit_of(recordings, term("wheel_eccentricity", "b.left")), 1)[0]


def test_the_size_in_each_recording_alone_is_given_and_equal_ones_agree(eccentric):
    found = repeats(eccentric(4e-4, 4e-4, 4e-4))
    assert found.agree
    assert np.all(np.abs(np.array(found.parameter.value) - 4e-4) < 3.0 * np.array(found.parameter.sigma))


def test_sizes_that_differ_do_not_agree(eccentric):
    found = repeats(eccentric(6e-4, 6e-4, 1e-4))
    assert not found.agree
    assert np.argmin(found.parameter.value) == 2


def test_one_recording_repeats_nothing(eccentric):
    assert repeats(eccentric(4e-4)) is None


def test_a_diagnosis_of_several_recordings_says_whether_they_agree(eccentric):
    answer = diagnose(eccentric(4e-4, 4e-4)).as_json()
    assert answer["findings"][0]["effect"] == "wheel_eccentricity"
    assert answer["findings"][0]["repeats"]["agree"] is True


def test_several_recordings_of_a_healthy_robot_without_poses_agree(drive):
    answer = diagnose([replace(drive(seed=seed, laps=1), poses=None) for seed in (4, 5)])
    assert answer.verdict == "agreement"
    assert answer.findings == ()
