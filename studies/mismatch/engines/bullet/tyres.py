"""Tyres that creep: the force of a contact grows with its slip, as of rubber, alike in all directions.

PyBullet's own friction acts along two directions of the world one by one, so that a robot that steers by
skidding would turn at a rate that depends on its heading (the Husky on a plane: by 15 %).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import pybullet


@dataclass(slots=True)
class Tyres:
    """The tyres of one robot.

    Attributes:
        grip: Friction of each wheel's tyre, by the number of its link.
        creep: Slip at which a tyre has 0.7 of its grip [m/s].
    """

    grip: dict[int, float]
    creep: float

    def push(self, body: int) -> None:
        """Apply the forces of all tyres for one step of the simulation."""
        links = list(self.grip)
        motion = dict(zip(links, pybullet.getLinkStates(body, links, computeLinkVelocity=1), strict=True))
        for contact in pybullet.getContactPoints(body):
            link, place, normal, load = contact[3], contact[5], contact[7], contact[9]
            if link not in motion or load <= 0.0:
                continue
            (cx, cy, cz), (vx, vy, vz), (wx, wy, wz) = (motion[link][item] for item in (0, 6, 7))
            x, y, z = place[0] - cx, place[1] - cy, place[2] - cz
            slip = vx + wy * z - wz * y, vy + wz * x - wx * z, vz + wx * y - wy * x
            into = sum(a * b for a, b in zip(slip, normal, strict=True))
            slip = tuple(a - into * b for a, b in zip(slip, normal, strict=True))
            share = -self.grip[link] * load / math.sqrt(self.creep**2 + sum(a * a for a in slip))
            pybullet.applyExternalForce(body, link, [share * a for a in slip], place, pybullet.WORLD_FRAME)
