"""Driving the MuJoCo robot on a rough floor: the motion that contacts make of the controller's wheel speeds.

The floor's surface is a sum of waves of 0.05 to 0.3 m. A wheel on its tangent plane meets the same point,
with the same normal, as on the surface itself, as long as the surface is less curved than the wheel. Longer
waves are left out: a truck that turns on them has its axle tilted the same way in each lap, and both wheels
roll the product of tilt and turn, so that the floor would look like wheels of another size.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import mujoco
import numpy as np
from numpy.typing import NDArray

from studies.mismatch.engines.mujoco.control import Controller, Program
from studies.mismatch.engines.mujoco.model import FEET, Robot, model_xml
from studies.mismatch.engines.true_motion import WINDOW, Drive, Nominal, contacts
from studies.mismatch.engines.vocabulary import WHEELS

Hook = Callable[["Scene", float], None]

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


SUBSTEPS = 10
RESOLUTION = 1.5e-4  # of the readings that the controller sees [rad, m]


@dataclass(slots=True)
class Scene:
    """The running world, which hooks may change in the middle of a drive."""

    model: mujoco.MjModel  # muJoCo's model
    data: mujoco.MjData  # muJoCo's state
    feet: NDArray[np.int64]  # geoms of FEET, the wheels and castors
    grip: NDArray[np.float64]  # friction of each contact pair at the start
    # numbers that a hook keeps from step to step, by name
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
    """Return the robot's drive of a program, its controller knowing the nominal robot.

    Hooks are called with the scene and the time [s] before every control period; `weave` is the amplitude
    with which the following truck swings about the link [rad]. FloatingPointError: contacts became unstable.
    """
    scene = _scene(robot)
    model, data = scene.model, scene.data
    dt, joints = robot.timestep * SUBSTEPS, ("joint_a", "joint_b", "link")
    where = np.array([model.joint(name).qposadr[0] for name in (*WHEELS, *joints)])
    bodies = [model.body(name).id for name in ("a", "b")]
    for _ in range(60):
        _settle(scene, floor)
    controller = Controller(nominal, dt, weave)
    controller.pose[1, 0] = -nominal.link
    rows, poses, touches = [], [], []
    leader = 0
    for row in range(len(program.v)):
        readings = data.qpos[where] * (1, 1, 1, 1, -1, 1, 1)
        readings[6] += robot.link
        rows.append(readings)
        poses.append(_poses(data, bodies))
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
            mujoco.mj_kinematics(model, data)  # after a step, positions are those of its beginning
    if data.warning.number.any():
        raise FloatingPointError(
            "MuJoCo warns that the contacts became unstable, so this drive is not valid; take another seed"
        )
    table = np.array(rows, dtype=np.float64)
    time = np.arange(len(rows), dtype=np.float64) * dt
    crossed = contacts(np.array(touches).reshape(len(rows), -1), WINDOW)
    path = np.array(poses)
    path[:, :, 2] = np.unwrap(path[:, :, 2], axis=0)
    return Drive(time, table[:, :4], table[:, 4:], path, crossed)


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
