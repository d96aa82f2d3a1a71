"""What every robot has a little of."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from omnimate.logs.folder import load_recording
from omnimate.mismatch import diagnose
from omnimate.mismatch.candidates.nuisances import BEFORE, _unforeseen
from omnimate.proof.cases import Case
from omnimate.proof.corpus import make


@given(st.integers(0, 10_000), st.integers(20, 80))
def test_what_is_not_foreseen_goes_with_nothing_that_was_there_before(seed, count):
    values = np.cumsum(np.random.default_rng(seed).normal(size=count))
    left = _unforeseen(values)
    for late in range(1, BEFORE + 1):
        assert abs(left[late:] @ values[:-late]) < 1e-6 * (np.abs(values) @ np.abs(values))


def test_what_wheels_round_off_is_no_delay_of_the_link(tmp_path):
    """Truck b holds the link's length, so that little but rounding is in the rate of the link."""
    make(tmp_path, Case(kind="null", effects=(), drive="shuttle", poses="none", trucks=2), 3)
    assert diagnose([load_recording(tmp_path / "1")]).findings == ()
