"""The signals that effects act on run on, whatever the geometry does."""

import numpy as np

from omnimate.mismatch.signals import expected_reading, readings_foreseen


def test_readings_that_odometry_foresees_go_on_where_a_joint_goes_round():
    """A jump by a whole turn would look like an effect to whatever shifts or smooths a reading."""
    time = np.linspace(0.0, 20.0, 401)
    yaw = np.linspace(0.0, 7.0, 401)
    still = np.zeros(401)
    path = np.stack(
        [np.stack([still + 1.0, still, still], axis=-1), np.stack([still, still, yaw], axis=-1)], axis=1
    )
    twist = np.diff(path, axis=0)
    foreseen = readings_foreseen(path, twist, time)
    assert np.abs(np.diff(foreseen, axis=0)).max() < 0.02
    wrapped = np.abs(np.exp(1j * foreseen[:, :2]) - np.exp(1j * expected_reading(path)[:, :2]))
    assert wrapped.max() < 1e-9
