"""The drives: what a robot can follow, lap by lap, and closed where the path is."""

import numpy as np
import pytest

from studies.mismatch.engines.programmes import STOP, commands, programme

PERIOD, SERVO = 0.02, (0.5, 1.2)


@pytest.mark.parametrize("kind", ["squares", "eights", "slalom", "shuttle"])
@pytest.mark.parametrize("seed", [0, 1])
def test_laps_stay_within_the_accelerations_of_a_robot_and_stop_before_and_after_each(kind, seed):
    laps = programme(np.random.default_rng(seed), kind, 3)
    assert laps == programme(np.random.default_rng(seed), kind, 3)
    driven, spans = commands(laps, PERIOD, SERVO)
    assert np.all(np.abs(np.diff(driven, axis=0)).max(axis=0) <= np.array(SERVO) * PERIOD * (1.0 + 1e-9))
    assert (driven[:, 0].min() < 0.0) == (kind == "shuttle")  # which reverses, as no other drive does
    assert [direction for direction, _, _ in spans] == [direction for direction, _ in laps]
    rows = [row for _, first, last in spans for row in (first, last)]
    assert rows == sorted(rows)
    for _, first, last in spans:
        assert not driven[first - 1].any()
        assert not driven[last : last + round(STOP / PERIOD)].any()


@pytest.mark.parametrize(("kind", "turned"), [("squares", 2.0 * np.pi), ("eights", 0.0)])
def test_a_lap_ends_with_the_heading_at_which_it_began(kind, turned):
    for direction, legs in programme(np.random.default_rng(5), kind, 2):
        sign = -1.0 if direction == "cw" else 1.0
        assert sum(rate * duration for _, rate, duration in legs) == pytest.approx(sign * turned)
