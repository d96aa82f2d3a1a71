"""What comes back at a pitch of the floor is told from what comes back along the way."""

import pytest

from omnimate.logs.folder import load_recording
from omnimate.mismatch.beats import beats
from omnimate.mismatch.choose import EMPTY, Choice
from omnimate.mismatch.folds import folds_of
from omnimate.mismatch.leftover import leftover
from omnimate.mismatch.noise import DEFAULT_LEVELS
from omnimate.mismatch.regression import Regression
from omnimate.mismatch.signals import signals_of
from omnimate.mismatch.windows import windows_of
from omnimate.proof.cases import Case
from omnimate.proof.corpus import make

PITCH = 0.7  # [m] of the corpus' slabs


@pytest.fixture(scope="module")
def proposed(tmp_path_factory):
    """Return a function that gives the beats proposed for a case of the corpus."""

    def told(case):
        folder = tmp_path_factory.mktemp("beats")
        make(folder, case, 12)
        windows = [windows_of(signals_of(load_recording(folder / "1")))]
        regression = Regression(windows, DEFAULT_LEVELS, (), folds_of(windows))
        left = leftover(regression, Choice([], [], regression.total), EMPTY)
        return [(term.component, term.fixed["quantity"]) for term, _ in beats(regression, left)]

    return told


def test_joints_between_slabs_are_found_under_both_wheels_at_their_pitch(proposed):
    found = proposed(Case("unknown", (("unknown", "left"),), "eights", "mocap", note="slabs"))
    (named,) = [what for component, what in found if component == "left" and "floor" in what]
    assert float(named.split()[-2]) == pytest.approx(PITCH, abs=0.011)


def test_an_even_floor_has_no_joints(proposed):
    assert not [one for one in proposed(Case("null", (), "eights", "mocap")) if "floor" in one[1]]
