"""Columns of candidates, and echoes: a channel's own rows, some windows later."""

from dataclasses import replace

import numpy as np
import pytest

from omnimate.mismatch.candidates.terms import smooth_terms, term
from omnimate.mismatch.recording.signals import signals_of
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
def test_a_delay_that_all_channels_share_explains_nothing(effect, regression, coarse_drive):
    found = regression(coarse_drive)
    columns = found.columns_of([term(effect, str(channel)) for channel in coarse_drive.vehicle.channels])
    shared = columns.sum(axis=1)
    assert np.linalg.norm(shared) < 0.6 * np.linalg.norm(columns, axis=0).max()
    assert abs(found.white[:, 0] @ shared) < 4.5 * np.linalg.norm(shared)


def test_no_effect_explains_the_rounding_of_coarse_encoders(regression, coarse_drive):
    found = regression(coarse_drive)
    terms = smooth_terms([signals_of(coarse_drive)])
    columns = found.columns_of(terms)
    z_scores = found.white[:, 0] @ columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-9)
    names = [single.key for single in terms for _ in single.probes]
    seen = {name: z for name, z in zip(names, z_scores.tolist(), strict=True) if abs(z) > 4.5}
    assert not seen
