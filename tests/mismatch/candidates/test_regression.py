"""Echoes are a channel's own rows, some windows later."""

import numpy as np


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
