"""What makes the simulator worse over ten seconds is not asserted, however well it fits a quarter of one."""

import pytest

from mismatch.answer import _contradicted
from mismatch.diagnosis import Change, Finding, Fit

FINDINGS = (Finding("wheel_diameter", "a.left", 0.98), Finding("unknown", "a", 0.9))


def fit(after):
    return Fit("", Change(1.1, 1.0), Change(1.1, 1.0), rerun={"a position": Change(0.01, after)})


@pytest.mark.parametrize("after", [0.004, 0.010, 0.011])
def test_effects_that_lead_nearer_or_as_near_keep_their_probability(after):
    assert _contradicted(FINDINGS, fit(after)) == FINDINGS


def test_effects_that_lead_farther_astray_become_possibilities_and_the_unknown_stays():
    named, unknown = _contradicted(FINDINGS, fit(0.015))
    assert named.probability == pytest.approx(0.98 / 1.5**2)
    assert unknown == FINDINGS[1]


def test_without_a_rerun_nothing_is_contradicted():
    assert _contradicted(FINDINGS, Fit("", Change(1.0, 1.0), Change(1.0, 1.0))) == FINDINGS
