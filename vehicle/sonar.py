"""The sonar calibrator: three ranges to an L-shaped corner of walls, solved to an absolute pose, U V.

Two sensors on the right of the truck look at the long wall, y = const, one behind at the short wall,
x = const. A sonar hears the first echo, hence the perpendicular distance from the sensor to the wall,
as long as the wall stands across its beam. The walls stand outside of the squares.
"""

import math
from dataclasses import dataclass

import numpy as np

from omnimate.vehicle.se2 import Array

UNKNOWN = np.full(3, np.nan)


@dataclass(frozen=True, slots=True)
class Sonar:
    """Where the sensors and the walls are, and how well the sensors measure.

    The defaults measure to 2 mm in position and 0.4 degrees in heading (one standard deviation), U V.
    """

    sigma: float = 0.002  # standard deviation of one range [m]
    sigma_per_range: float = 0.0  # part of the range that is added to its standard deviation; 0.003 in O 3
    baseline: float = 0.405  # distance of the two sensors on the right [m]
    side: float = 0.3  # distance of these two sensors from the truck's middle line [m]
    rear: float = 0.3  # distance of the sensor behind from the drive axle [m]
    wall_x: float = -2.5  # place of the short wall, x = const [m]
    wall_y: float = -6.0  # place of the long wall, y = const [m]
    beam: float = math.pi / 4.0  # largest angle from beam to the wall's normal with an echo [rad]

    def ranges(self, pose: Array) -> Array:
        """Return the ranges right front, right rear, behind [m] `(3,)` at a pose `(3,)`; nan without echo."""
        x, y, theta = (float(value) for value in pose)
        cos, sin = math.cos(theta), math.sin(theta)
        side_range = y - self.side * cos - self.wall_y
        tilt = 0.5 * self.baseline * sin
        ranges = np.array([side_range + tilt, side_range - tilt, x - self.rear * cos - self.wall_x])
        has_echo = cos > math.cos(self.beam) and bool(np.all(ranges > 0.0))
        return ranges if has_echo else UNKNOWN.copy()

    def range_sigma(self, ranges: Array) -> Array:
        """Return the standard deviation of each range [m] `(3,)`."""
        return self.sigma + self.sigma_per_range * ranges

    def solve(self, ranges: Array) -> Array:
        """Return the pose `(3,)` from three ranges [m]; nan where one is missing."""
        tilt = (ranges[0] - ranges[1]) / self.baseline
        if not (np.all(np.isfinite(ranges)) and abs(tilt) <= 1.0):
            return UNKNOWN.copy()
        theta = math.asin(tilt)
        cos = math.cos(theta)
        y = self.wall_y + 0.5 * (ranges[0] + ranges[1]) + self.side * cos
        return np.array([self.wall_x + ranges[2] + self.rear * cos, y, theta])

    def pose_sigma(self, ranges: Array) -> Array:
        """Return the standard deviations of the pose solved from three ranges, `(3,)`, to first order."""
        front, back, behind = self.range_sigma(ranges)
        pose = self.solve(ranges)
        cos, sin = math.cos(pose[2]), math.sin(pose[2])
        heading = math.hypot(front, back) / (self.baseline * cos)
        y = math.hypot(0.5 * math.hypot(front, back), self.side * sin * heading)
        return np.array([math.hypot(behind, self.rear * sin * heading), y, heading])

    def fix(self, pose: Array, deviates: Array) -> tuple[Array, Array]:
        """Return the pose `(3,)` measured at a true one `(3,)`, and its sigma; nan where a wall is not seen.

        `deviates` `(3,)` are standard normal, one for each range.
        """
        exact = self.ranges(pose)
        measured = exact + self.range_sigma(exact) * deviates
        return self.solve(measured), self.pose_sigma(measured)
