"""Columns of candidates, and echoes: a channel's own rows, some windows later."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.mismatch.candidates.terms import term
from omnimate.motion.paths import figure_eight
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth


def test_an_echo_of_linkage_and_poses_alike_is_the_row_of_as_many_windows_before(regression, drive, watched):
    found = regression(watched(drive(laps=1)))
    echoes, channels = found.lagged_rows(2), found.windows[0].measured.shape[1]
    assert echoes.shape == (len(found.white), 2 * channels)
    for channel in range(channels):
        mine = np.flatnonzero(found.channel == channel)
        rows = dict(zip(found.moment[mine].tolist(), found.white[mine, 0].tolist(), strict=True))
        for late in (1, 2):
            expected = [rows.get(moment - late, 0.0) for moment in found.moment[mine].tolist()]
            np.testing.assert_array_equal(echoes[mine, 2 * channel + late - 1], expected)
        assert not echoes[found.channel != channel][:, 2 * channel : 2 * channel + 2].any()


@pytest.fixture(scope="module")
def coarse_drive():
    """A healthy robot whose wheel encoders have 900 counts a turn, half a millimetre each."""
    vehicle = reference_vehicle()
    encoders = tuple(
        replace(encoder, counts_per_turn=900.0) if encoder.channel in vehicle.wheels else encoder
        for encoder in vehicle.encoders
    )
    vehicle = replace(vehicle, encoders=encoders)
    return simulate(vehicle, Truth(vehicle, seed=4), figure_eight(1.0, 2))


@pytest.mark.parametrize("effect", ["latency", "clock_drift"])
def test_a_delay_that_all_channels_share_changes_nothing_and_explains_no_rounding(
    effect, regression, coarse_drive
):
    found = regression(coarse_drive)
    columns = found.columns_of([term(effect, str(channel)) for channel in coarse_drive.vehicle.channels])
    sizes = np.linalg.norm(columns, axis=0)
    assert np.linalg.norm(columns.sum(axis=1)) < 0.1 * sizes.max()
    assert np.all(np.abs(found.white[:, 0] @ columns) < 5.0 * sizes)
