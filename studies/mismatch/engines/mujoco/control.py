"""The controller of the MuJoCo robot: one truck follows a program by odometry, the other follows the link.

It knows the readings of the encoders and the nominal robot. It knows no true pose.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from studies.mismatch.engines.true_motion import Nominal

WEAVING = 9.0  # [s] in which the following truck turns to one side of the link and the other
KX, KY, KTHETA, KLINK, KJOINT = 1.0, 6.0, 2.5, 1.5, 1.5


@dataclass(slots=True)
class Controller:
    """Odometry of both trucks and the wheel speeds that keep them on their path.

    Attributes:
        nominal: The robot as it is described.
        dt: Control period [s].
        weave: Amplitude with which the following truck swings about the link [rad].
        time: Time driven so far, without the stops [s].
        goal: Pose of the leading truck that the program asks for [m, m, rad], shape `(3,)`.
        pose: Poses of both trucks by odometry, shape `(2, 3)`.
        wheels: Last wheel angles [rad], shape `(4,)`; None before the first step.
    """

    nominal: Nominal
    dt: float
    weave: float = 0.0
    time: float = 0.0
    goal: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    pose: NDArray[np.float64] = field(default_factory=lambda: np.zeros((2, 3)))
    wheels: NDArray[np.float64] | None = None

    def speeds(
        self,
        v: float,
        w: float,
        leader: int,
        wheels: NDArray[np.float64],
        joints: NDArray[np.float64],
        link: float,
    ) -> NDArray[np.float64]:
        """Return the wheel speeds that follow from the readings and the program [rad/s], shape `(4,)`.

        Args:
            v: Speed that the program asks of the leading truck [m/s].
            w: Turn rate that the program asks of it [rad/s].
            leader: Number of the leading truck, 0 or 1.
            wheels: Angles of the four wheels [rad].
            joints: Angles of both joints [rad].
            link: Length of the link [m].
        """
        self._reckon(wheels)
        self.time += self.dt if v or w else 0.0  # no weaving at rest: poses are measured there
        self.goal = _advance(self.goal, v * self.dt, w * self.dt)
        x, y, theta = _seen_from(self.pose[leader], self.goal)
        command = np.zeros((2, 2))
        command[leader] = v * np.cos(theta) + KX * x, w + abs(v) * KTHETA * theta + v * KY * y + 1.0 * theta
        self._follow(command, leader, joints, link)
        out = np.empty(4)
        for i, (speed, turn) in enumerate(command):
            half = turn * self.nominal.tracks[i] / 2
            out[2 * i : 2 * i + 2] = (speed - half, speed + half) / self.nominal.radii[2 * i : 2 * i + 2]
        return out

    def switch(self, leader: int) -> None:
        """Let the program go on from the pose of another leading truck."""
        self.goal = self.pose[leader].copy()

    def _follow(
        self, command: NDArray[np.float64], leader: int, joints: NDArray[np.float64], link: float
    ) -> None:
        """Keep the slider at rest and the following truck in line with the link."""
        other, stretch = 1 - leader, link - self.nominal.link
        along = command[leader, 0] * np.cos(joints[leader])
        pull = along + (KLINK * stretch if other == 1 else -KLINK * stretch)
        command[other, 0] = np.clip(pull / np.cos(joints[other]), -0.8, 0.8)
        across = command[:, 0] * np.sin(joints)
        command[other, 1] = (across[0] - across[1]) / link - KJOINT * (
            joints[other] - self.weave * np.sin(2 * np.pi * self.time / WEAVING)
        )

    def _reckon(self, wheels: NDArray[np.float64]) -> None:
        last = wheels if self.wheels is None else self.wheels
        rolled = (wheels - last) * self.nominal.radii
        self.wheels = wheels
        for i in range(2):
            left, right = rolled[2 * i : 2 * i + 2]
            self.pose[i] = _advance(self.pose[i], (left + right) / 2, (right - left) / self.nominal.tracks[i])


def _advance(pose: NDArray[np.float64], way: float, turn: float) -> NDArray[np.float64]:
    middle = pose[2] + turn / 2
    return np.array([pose[0] + way * np.cos(middle), pose[1] + way * np.sin(middle), pose[2] + turn])


def _seen_from(pose: NDArray[np.float64], goal: NDArray[np.float64]) -> tuple[float, float, float]:
    dx, dy = goal[:2] - pose[:2]
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return c * dx + s * dy, c * dy - s * dx, goal[2] - pose[2]
