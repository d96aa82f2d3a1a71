"""The drives: what a robot can follow, lap by lap, and closed where the path is."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from studies.mismatch.engines.programmes import STOP, commands, programme

KINDS = ("squares", "eights", "slalom", "shuttle")
PERIOD, SERVO = 0.02, (0.5, 1.2)


def laps_of(kind, seed, count=2):
    return programme(np.random.default_rng(seed), kind, count)


@given(st.sampled_from(KINDS), st.integers(0, 2**32))
def test_the_same_seed_gives_the_same_programme(kind, seed):
    assert laps_of(kind, seed) == laps_of(kind, seed)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_commands_stay_within_the_accelerations_of_a_robot(kind, seed):
    driven, _ = commands(laps_of(kind, seed), PERIOD, SERVO)
    change = np.abs(np.diff(driven, axis=0)).max(axis=0)
    assert np.all(change <= np.array(SERVO) * PERIOD * (1.0 + 1e-9))


@pytest.mark.parametrize("kind", KINDS)
def test_laps_follow_each_other_with_a_stop_before_and_after_each(kind):
    laps = laps_of(kind, 3, 3)
    driven, spans = commands(laps, PERIOD, SERVO)
    assert [direction for direction, _, _ in spans] == [direction for direction, _ in laps]
    rows = [row for _, first, last in spans for row in (first, last)]
    assert rows == sorted(rows)
    stop = round(STOP / PERIOD)
    for _, first, last in spans:
        assert not driven[first - 1].any()
        assert not driven[last : last + stop].any()


@pytest.mark.parametrize(("kind", "turned"), [("squares", 2.0 * np.pi), ("eights", 0.0)])
def test_a_lap_ends_with_the_heading_at_which_it_began(kind, turned):
    for direction, legs in laps_of(kind, 5):
        sign = -1.0 if direction == "cw" else 1.0
        assert sum(rate * duration for _, rate, duration in legs) == pytest.approx(sign * turned)


def test_a_shuttle_reverses_and_no_other_drive_does():
    for kind in KINDS:
        driven, _ = commands(laps_of(kind, 1), PERIOD, SERVO)
        assert (driven[:, 0].min() < 0.0) == (kind == "shuttle")
