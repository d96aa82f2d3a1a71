"""Driving the MuJoCo robot: a truck that follows its program by odometry, a truck that follows it, and a log.

The controller knows the encoders' readings alone; the world is what the contacts make of its wheel speeds.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from proof.mujoco_robot import FEET, WHEELS, model_xml

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from proof.mujoco_floor import Floor
    from proof.mujoco_paths import Program
    from proof.mujoco_robot import Robot

    Hook = Callable[["Scene", float], None]

SUBSTEPS = 10
RESOLUTION = 1.5e-4  # of the readings that the controller sees [rad, m]
WEAVING = 9.0  # [s] in which the following truck turns to one side of the link and the other
KX, KY, KTHETA, KLINK, KJOINT = 1.0, 6.0, 2.5, 1.5, 1.5


@dataclass(frozen=True, slots=True)
class Nominal:
    """The robot as its owner believes it to be: radii [m] in the order of WHEELS, tracks [m], link [m]."""

    radii: NDArray[np.float64]
    tracks: NDArray[np.float64]
    link: float


@dataclass(frozen=True, slots=True)
class Drive:
    """What happened, a row for each SYNC: wheel angles (N, 4), joints (N, 2), link (N,), poses (N, 2, 3).

    Heights (N, 4) are those of the hubs; `crossings` are rows (cable, first row, last row) of contact.
    """

    time: NDArray[np.float64]
    wheels: NDArray[np.float64]
    joints: NDArray[np.float64]
    link: NDArray[np.float64]
    poses: NDArray[np.float64]
    heights: NDArray[np.float64]
    crossings: tuple[tuple[int, int, int], ...]


@dataclass(slots=True)
class Scene:
    """The running world; hooks may change it in the middle of a drive."""

    model: mujoco.MjModel
    data: mujoco.MjData
    feet: NDArray[np.int64]
    grip: NDArray[np.float64]
    notes: dict[str, list[float]] = field(default_factory=dict)

    def pair(self, foot: str) -> int:
        """Return the number of the contact pair of a wheel or castor with its floor."""
        return FEET.index(foot)


@dataclass(slots=True)
class Controller:
    """Odometry of the leading truck and the wheel speeds that keep both on their way."""

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
        """Return the wheel speeds [rad/s], shape (4,), that follow from readings and the program's v, w."""
        self._reckon(wheels)
        self.time += self.dt
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
        """Make the other truck's place the one from which the program goes on."""
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


def drive(
    robot: Robot,
    floor: Floor,
    program: Program,
    nominal: Nominal,
    hooks: tuple[Hook, ...] = (),
    weave: float = 0.0,
) -> Drive:
    """Return the robot's drive of a program; `weave` [rad] swings the following truck about the link."""
    scene = _scene(robot)
    model, data = scene.model, scene.data
    dt, joints = robot.timestep * SUBSTEPS, ("joint_a", "joint_b", "link")
    where = np.array([model.joint(name).qposadr[0] for name in (*WHEELS, *joints)])
    bodies = [model.body(name).id for name in ("a", "b")]
    hubs = [model.body(name).id for name in WHEELS]
    for _ in range(60):
        _settle(scene, floor)
    controller = Controller(nominal, dt, weave)
    controller.pose[1, 0] = -nominal.link
    rows, poses, heights, touches = [], [], [], []
    leader = 0
    for row in range(len(program.v)):
        readings = data.qpos[where] * (1, 1, 1, 1, -1, 1, 1)
        readings[6] += robot.link
        rows.append(readings)
        poses.append(_poses(data, bodies))
        heights.append(data.xpos[hubs, 2])
        touches.append(_touched(scene, len(robot.cables)))
        if (new := 0 if program.leader[row] == "a" else 1) != leader:
            leader = new
            controller.switch(leader)
        seen = np.floor(readings / RESOLUTION) * RESOLUTION
        data.ctrl[:4] = controller.speeds(
            program.v[row], program.w[row], leader, seen[:4], seen[4:6], seen[6]
        )
        for hook in hooks:
            hook(scene, row * dt)
        for _ in range(2):
            floor.lay(scene.feet, data)
            mujoco.mj_step(model, data, SUBSTEPS // 2)
            mujoco.mj_kinematics(model, data)  # a step leaves the places of its beginning behind
    table = np.array(rows)
    return Drive(
        np.arange(len(rows)) * dt, table[:, :4], table[:, 4:6], table[:, 6], np.array(poses), np.array(heights),
        _crossings(np.array(touches)),
    )  # fmt: skip


def _scene(robot: Robot) -> Scene:
    model = mujoco.MjModel.from_xml_string(model_xml(robot))
    feet = np.array([model.geom(name).id for name in FEET])
    return Scene(model, mujoco.MjData(model), feet, model.pair_friction[:, 0].copy())


def _settle(scene: Scene, floor: Floor) -> None:
    mujoco.mj_kinematics(scene.model, scene.data)
    floor.lay(scene.feet, scene.data)
    mujoco.mj_step(scene.model, scene.data, SUBSTEPS)
    mujoco.mj_kinematics(scene.model, scene.data)


def _poses(data: mujoco.MjData, bodies: list[int]) -> NDArray[np.float64]:
    """Return x, y, theta of both trucks' axle centres."""
    turn = data.xmat[bodies]
    return np.column_stack([data.xpos[bodies, :2], np.arctan2(turn[:, 3], turn[:, 0])])


def _touched(scene: Scene, cables: int) -> NDArray[np.bool_]:
    out = np.zeros(cables, bool)
    if cables:
        first = scene.model.geom("cable 0").id
        for pair in scene.data.contact.geom:
            for geom in pair:
                if first <= geom < first + cables:
                    out[geom - first] = True
    return out


def _crossings(touches: NDArray[np.bool_]) -> tuple[tuple[int, int, int], ...]:
    """Return each contact with a cable; touches within half a second are one crossing."""
    out: list[tuple[int, int, int]] = []
    for cable in range(touches.shape[1] if touches.ndim == 2 else 0):
        rows = np.flatnonzero(touches[:, cable])
        if len(rows):
            for part in np.split(rows, np.flatnonzero(np.diff(rows) > 33) + 1):
                out.append((cable, int(part[0]), int(part[-1]) + 1))
    return tuple(sorted(out, key=lambda crossing: crossing[1]))


def _advance(pose: NDArray[np.float64], way: float, turn: float) -> NDArray[np.float64]:
    middle = pose[2] + turn / 2
    return np.array([pose[0] + way * np.cos(middle), pose[1] + way * np.sin(middle), pose[2] + turn])


def _seen_from(pose: NDArray[np.float64], goal: NDArray[np.float64]) -> tuple[float, float, float]:
    dx, dy = goal[:2] - pose[:2]
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return c * dx + s * dy, c * dy - s * dx, goal[2] - pose[2]
