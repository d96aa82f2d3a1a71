"""Driving the MuJoCo robot: what the contacts make of the controller's wheel speeds, as a log."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from proof.mujoco_control import Controller
from proof.mujoco_model import model_xml
from proof.mujoco_robot import FEET, WHEELS

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from proof.mujoco_control import Nominal
    from proof.mujoco_floor import Floor
    from proof.mujoco_paths import Program
    from proof.mujoco_robot import Robot

    Hook = Callable[["Scene", float], None]

SUBSTEPS = 10
RESOLUTION = 1.5e-4  # of the readings that the controller sees [rad, m]


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


def drive(
    robot: Robot,
    floor: Floor,
    program: Program,
    nominal: Nominal,
    hooks: tuple[Hook, ...] = (),
    weave: float = 0.0,
) -> Drive:
    """Return the robot's drive of a program; `weave` [rad] swings the following truck about the link.

    Raises:
        FloatingPointError: MuJoCo found the contacts unstable.
    """
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
    if data.warning.number.any():
        raise FloatingPointError("the contacts became unstable; this drive is no physics")
    table = np.array(rows, dtype=np.float64)
    time = np.arange(len(rows), dtype=np.float64) * dt
    crossed = _crossings(np.array(touches))
    places = np.array(poses), np.array(heights)
    return Drive(time, table[:, :4], table[:, 4:6], table[:, 6], *places, crossed)


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
            parts = np.split(rows, np.flatnonzero(np.diff(rows) > 33) + 1)
            out.extend((cable, int(part[0]), int(part[-1]) + 1) for part in parts)
    return tuple(sorted(out, key=lambda crossing: crossing[1]))
