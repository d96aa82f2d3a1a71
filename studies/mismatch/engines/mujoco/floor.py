"""A rough floor for MuJoCo: each wheel and castor has a plane that is tangent to the surface below it.

The surface is a sum of waves of 0.05 to 0.3 m. A wheel on its tangent plane meets the same point, with the
same normal, as on the surface itself, as long as the surface is less curved than the wheel. Longer waves are
left out: a truck that turns on them has its axle tilted the same way in each lap, and both wheels roll the
product of tilt and turn, so that the floor would look like wheels of another size.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from studies.mismatch.engines.mujoco.robot import FEET

if TYPE_CHECKING:
    import mujoco
    from numpy.typing import NDArray

WAVES = 16


class Floor:
    """A random surface of a given rms slope; the same state of the generator gives the same surface."""

    def __init__(self, rng: np.random.Generator, slope: float) -> None:
        wavelength = np.exp(rng.uniform(np.log(0.05), np.log(0.3), WAVES))
        direction = rng.uniform(0, 2 * np.pi, WAVES)
        self.k = 2 * np.pi / wavelength * np.stack([np.cos(direction), np.sin(direction)])
        self.phase = rng.uniform(0, 2 * np.pi, WAVES)
        self.amplitude = slope * wavelength / (2 * np.pi) * np.sqrt(2 / WAVES)

    def at(self, xy: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return heights [m], shape `(N,)`, and slopes, shape `(N, 2)`, at places [m], shape `(N, 2)`."""
        angle = xy @ self.k + self.phase
        return np.sin(angle) @ self.amplitude, (np.cos(angle) * self.amplitude) @ self.k.T

    def lay(self, feet: NDArray[np.int64], data: mujoco.MjData) -> None:
        """Move the plane of each wheel and castor under it; `feet` are the geoms of FEET."""
        xy = data.geom_xpos[feet, :2]
        height, slope = self.at(xy)
        n = len(FEET)
        data.mocap_pos[:n, :2] = xy
        data.mocap_pos[:n, 2] = height
        data.mocap_quat[:n, 0] = 1.0
        data.mocap_quat[:n, 1] = slope[:, 1] / 2
        data.mocap_quat[:n, 2] = -slope[:, 0] / 2
