"""Floors for PyBullet: a height field of a given roughness, and boxes on it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pybullet

if TYPE_CHECKING:
    from numpy.typing import NDArray

CELL, WAVE = 0.05, 0.1  # [m] between two heights, and below which the surface is smooth
MARGIN = 3.0  # [m] of floor beyond the path that is commanded
GRIP = 1.0  # friction of the floor; that of a contact is the product of both


@dataclass(frozen=True, slots=True)
class Box:
    """A flat box on the floor, under the path of one wheel.

    Attributes:
        wheel: Wheel that meets it; others pass through it.
        place: Its middle [m].
        heading: Direction in which it is crossed [rad].
        size: Its length along this direction, its width and its height above the floor [m].
    """

    wheel: str
    place: tuple[float, float]
    heading: float
    size: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Floor:
    """A floor.

    Attributes:
        slope: Rms slope of its surface in any direction; 0 for a plane.
        seed: Seed of the surface.
        boxes: Boxes on it.
    """

    slope: float
    seed: int = 0
    boxes: tuple[Box, ...] = ()

    def lay(self, path: NDArray[np.float64]) -> tuple[int, float]:
        """Lay the surface under a path `(N, 2)` [m]; return its number and the height of its top [m]."""
        middle = 0.5 * (path.min(axis=0) + path.max(axis=0))
        shape, lift, top = pybullet.createCollisionShape(pybullet.GEOM_PLANE), 0.0, 0.0
        if self.slope:
            cells = np.ceil((np.ptp(path, axis=0) + 2.0 * MARGIN) / CELL).astype(int)
            height = self._heights(*cells)
            top = float(height.max())
            lift = 0.5 * float(height.min() + top)  # a height field lies about its middle
            shape = pybullet.createCollisionShape(
                pybullet.GEOM_HEIGHTFIELD,
                meshScale=[CELL, CELL, 1.0],
                heightfieldData=height.T.ravel().tolist(),
                numHeightfieldRows=int(cells[0]),
                numHeightfieldColumns=int(cells[1]),
            )
        floor = pybullet.createMultiBody(0, shape, basePosition=[*middle, lift])
        pybullet.changeDynamics(floor, -1, lateralFriction=GRIP)
        return int(floor), top

    def _heights(self, rows: int, columns: int) -> NDArray[np.float64]:
        """Return a random surface of this slope, shape `(rows, columns)`."""
        rough = np.random.default_rng([self.seed, rows, columns]).normal(size=(rows, columns))
        frequency = np.hypot(np.fft.fftfreq(rows, CELL)[:, None], np.fft.fftfreq(columns, CELL))
        smooth = np.fft.ifft2(np.fft.fft2(rough) * np.exp(-((WAVE * frequency) ** 2))).real
        return np.asarray(smooth * self.slope / np.gradient(smooth, CELL, axis=0).std())


def lay_box(box: Box) -> int:
    """Lay a box on the floor, and return its number in the simulation."""
    half = [0.5 * box.size[0], 0.5 * box.size[1], box.size[2]]  # half of it below the floor's middle
    shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half)
    turn = pybullet.getQuaternionFromEuler([0.0, 0.0, box.heading])
    number = pybullet.createMultiBody(0, shape, basePosition=[*box.place, 0.0], baseOrientation=turn)
    pybullet.changeDynamics(number, -1, lateralFriction=GRIP)
    return int(number)
