"""What castors do about a reversal is noise there, and nowhere else."""

import numpy as np
import pytest

from omnimate.mismatch.noise import DEFAULT_LEVELS, variance_of
from omnimate.mismatch.signals import signals_of
from omnimate.mismatch.windows import windows_of
from omnimate.motion.paths import out_and_back
from omnimate.vcan_sim.effects.castor_kick import CastorKick
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth


@pytest.fixture(scope="module")
def signals():
    vehicle = reference_vehicle()
    return signals_of(simulate(vehicle, Truth(vehicle, seed=3), out_and_back(2.0, 1)))


def test_a_kick_loosens_its_own_trucks_heading_about_reversals_only(signals):
    still, kicked = windows_of(signals), windows_of(signals, kicks=[CastorKick(component="b", yaw=0.02)])
    more = variance_of(kicked, DEFAULT_LEVELS) - variance_of(still, DEFAULT_LEVELS)
    assert not np.any(more[:, [0, 2]])
    loose = more[:, 1] > 0.0
    np.testing.assert_allclose(more[loose, 1], 0.02**2)
    assert 0 < loose.sum() < 0.2 * len(loose)
    travel = np.abs(np.add.reduceat(signals.block.twist[:, 1, 0], still.ends[:-1]))
    fastest = travel.max()
    assert np.all(travel[np.flatnonzero(loose[1:])] < 0.75 * fastest)


def test_a_kick_is_told_before_and_after_it_with_some_scatter(signals):
    still, kicked = windows_of(signals), windows_of(signals, kicks=[CastorKick(component="b", yaw=0.02)])
    more = kicked.rounding - still.rounding
    kicks = np.flatnonzero(more[:, 5, 5])
    assert len(kicks) == 1
    assert np.all(np.sqrt(more[kicks, 5, 5]) < 0.02)
    assert not np.any(more[:, 2, 2])
