"""Drives of a robot as variables, and what an error of a wheel's travel does to whitened rows."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.signal import lfilter

from omnimate.effects.variables import VARIABLES
from omnimate.mismatch.learn.learn import learn

STEP, STEPS, WINDOW, FOLDS = 0.1, 2400, 5, 8
SCALE = 2e-3  # of the laws


@dataclass
class World:
    variables: dict
    travel: np.ndarray
    noise: np.ndarray
    folds: np.ndarray

    def columns(self, basis):
        """Errors per metre, summed over windows; what an error leaves is forgotten within ten windows."""
        pushed = basis * self.travel[:, None]
        return lfilter([2e3], [1.0, -0.9], pushed.reshape(-1, WINDOW, basis.shape[1]).sum(axis=1), axis=0)

    def size(self, f, gain):
        """The factor at which a law `(N,)` explains `gain` nats."""
        return np.sqrt(2.0 * gain / (self.columns(f[:, None]) ** 2).sum())

    def learned(self, f=0.0, noise=None, **changed):
        rows = (self.noise if noise is None else noise) + self.columns((f + np.zeros(STEPS))[:, None])[:, 0]
        settings = {"component": "a.left", "acts_on": "travel", "scale": SCALE, **changed}
        return learn(self.variables, self.columns, rows, self.folds, **settings)

    def recovered(self, law, f):
        """Share of what the true law explains that the learned one explains on rows without noise."""
        if law is None:
            return 0.0
        value = sum(effect.value(self.variables) for effect in law.effects) + np.zeros(STEPS)
        true, left = (self.columns(one[:, None]) for one in (f, f - value))
        return 1.0 - (left**2).sum() / (true**2).sum()


def smooth(rng, low, high, hold):
    """A signal that goes from level to level, as a driver drives."""
    levels = np.repeat(rng.uniform(low, high, STEPS // hold + 1), hold)[:STEPS]
    return lfilter([0.2], [1.0, -0.8], levels)


def drive(seed):
    rng = np.random.default_rng(seed)
    speed, turn_rate = smooth(rng, -0.3, 0.8, 60), smooth(rng, -0.9, 0.9, 50)
    heading = np.cumsum(turn_rate) * STEP
    variables = {
        "speed": speed,
        "acceleration": np.gradient(speed) / STEP,
        "turn_rate": turn_rate,
        "load": speed * turn_rate,
        "way": np.cumsum(np.abs(speed)) * STEP,
        "time": STEP * np.arange(1, STEPS + 1),
        "heading": heading,
        "x": np.cumsum(speed * np.cos(heading)) * STEP,
        "y": np.cumsum(speed * np.sin(heading)) * STEP,
        "wheel_angle": np.cumsum(speed) * STEP / 0.075,
        "joint_a": 0.6 * np.sin(0.3 * STEP * np.arange(STEPS)) * smooth(rng, 0.2, 1.0, 80),
    }
    assert set(variables) <= set(VARIABLES)
    folds = np.arange(STEPS // WINDOW) * FOLDS // (STEPS // WINDOW)
    return World(variables, np.abs(speed) * STEP, rng.standard_normal(STEPS // WINDOW), folds)


@pytest.fixture(name="drive")
def drive_fixture():
    return drive
