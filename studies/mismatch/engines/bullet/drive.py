"""Driving a robot in PyBullet: floors, tyres, the controller, and the motion that contacts make of it.

Tyres that creep have a force that grows with their slip, as of rubber, alike in all directions. PyBullet's
own friction acts along two directions of the world one by one, so that a robot that steers by skidding
would turn at a rate that depends on its heading (the Husky on a plane: by 15 %).
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pybullet
from numpy.typing import NDArray

from studies.mismatch.engines.bullet.chassis import Chassis
from studies.mismatch.engines.programmes import wheel_ways
from studies.mismatch.engines.true_motion import Drive, Nominal, contacts
from studies.mismatch.engines.vocabulary import Array

Hook = Callable[["Scene", float], None]

CELL, WAVE = 0.05, 0.1  # [m] between two heights, and below which the surface is smooth
MARGIN = 3.0  # [m] of floor beyond the path that is commanded
GRIP = 1.0  # friction of the floor; that of a contact is the product of both


@dataclass(frozen=True, slots=True)
class Box:
    """A flat box on the floor, under the path of one wheel."""

    wheel: str  # wheel that meets it; others pass through it
    place: tuple[float, float]  # its middle [m]
    heading: float  # direction in which it is crossed [rad]
    # its length along this direction, its width and its height above the floor [m]
    size: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Floor:
    slope: float  # rms slope of its surface in any direction; 0 for a plane
    seed: int = 0  # seed of the surface
    boxes: tuple[Box, ...] = ()  # boxes on it

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


@dataclass(slots=True)
class Tyres:
    grip: dict[int, float]  # friction of each wheel's tyre, by the number of its link
    creep: float  # slip at which a tyre has 0.7 of its grip [m/s]

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


HOLD, INTO = 0.6, 2.0  # gains of `wheel_ways`, the second over the link's length
STEP = 0.0025  # [s], the longest step; bends creep outwards by half a step times their acceleration
ITERATIONS = 300  # of the solver, which stops when it has converged; with the usual 50 a straight bends
SETTLING = 0.6  # [s] at rest before a drive, in which the robot comes down on the floor
DROP = 0.003  # [m] above the floor from which it comes down
HOLDING = 200.0  # [N m] or [N] of a motor that holds its joint
LIFTING = 2000.0  # [N] of one that moves a load
UPRIGHT = 0.9  # cosine of the inclination beyond which a robot falls over
APART = 0.5  # [s] without a touch, after which the next one is another contact


class TippedError(Exception):
    """A robot fell over, or folded: its drive is none."""


@dataclass(frozen=True, slots=True)
class Course:
    commands: Array  # speed [m/s] and turn rate [rad/s] of the leading truck in each period, shape `(N, 2)`
    laps: Sequence[tuple[str, int, int]]  # laps as (direction, first row, last row)
    period: float  # period of SYNC [s]
    angles: Array  # angles of the wheels that the counters show at the start [rad], shape `(2 T,)`

    def path(self) -> Array:
        """Return where the commands lead from the origin [m], shape `(N + 1, 2)`."""
        heading = np.concatenate(([0.0], np.cumsum(self.commands[:, 1]))) * self.period
        steps = self.commands[:, 0] * self.period * np.exp(1j * heading[:-1])
        place = np.concatenate(([0.0], np.cumsum(steps)))
        return np.stack([place.real, place.imag], axis=1)


@dataclass(slots=True)
class Scene:
    """The running world, which hooks may change in the middle of a drive."""

    body: int  # number of the robot
    floor: int  # number of the floor
    links: dict[str, int]  # number of each link, by its name
    joints: dict[str, int]  # number of each joint, by its name
    tyres: Tyres | None  # tyres that creep; None where they hold
    # frame of the base as its centre of mass sees it: place [m] and quaternion
    base: tuple[Sequence[float], Sequence[float]]

    def grip(self, link: str, friction: float) -> None:
        """Set the friction of a wheel or a foot."""
        if self.tyres is not None and self.links[link] in self.tyres.grip:
            self.tyres.grip[self.links[link]] = friction
        else:
            pybullet.changeDynamics(self.body, self.links[link], lateralFriction=friction)

    def let_through(self, link: str) -> None:
        """Let a link pass through the floor from now on."""
        pybullet.setCollisionFilterPair(self.body, self.floor, self.links[link], -1, 0)

    def move(self, joint: str, to: float) -> None:
        """Move a joint that is held to another place [rad, m]."""
        pybullet.setJointMotorControl2(
            self.body, self.joints[joint], pybullet.POSITION_CONTROL, to, force=LIFTING
        )

    def place(self, link: str) -> tuple[float, float]:
        """Return where a link is on the floor [m]."""
        x, y, _ = pybullet.getLinkState(self.body, self.links[link])[0]
        return x, y


def drive(
    chassis: Chassis, floor: Floor, course: Course, nominal: Nominal, hooks: Sequence[Hook] = ()
) -> Drive:
    """Return a robot's drive of a course, its controller knowing the nominal robot.

    Hooks are called with the scene and the time [s] before every period. TippedError: the robot fell over.
    """
    pybullet.connect(pybullet.DIRECT)  # the only simulation of this process, so that no call names it
    try:
        return _Run(chassis, floor, course, nominal).driven(hooks)
    finally:
        pybullet.disconnect()


class _Run:
    """One drive in a simulation of its own."""

    def __init__(self, chassis: Chassis, floor: Floor, course: Course, nominal: Nominal) -> None:
        self.chassis, self.course, self.nominal = chassis, course, nominal
        self.steps = math.ceil(course.period / STEP - 1e-9)
        pybullet.setGravity(0.0, 0.0, -9.81)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=course.period / self.steps,
            numSolverIterations=ITERATIONS,
            enableConeFriction=0,  # each direction of friction by itself; together they converge worse
            deterministicOverlappingPairs=1,
        )
        ground, top = floor.lay(course.path())
        self.scene = _scene(chassis, ground, chassis.height + top + DROP)
        self.boxes = [self._laid(box) for box in floor.boxes]
        joints = self.scene.joints
        self.driven_by = [[joints[name] for name in wheel.joints] for wheel in chassis.wheels.values()]
        self.linkage = [joints[name] for name in ("joint_a", "joint_b", "link") if name in joints]
        self._settle()

    def _laid(self, box: Box) -> int:
        """Lay a box that only the wheel meets which it is meant for, and return its number."""
        half = [0.5 * box.size[0], 0.5 * box.size[1], box.size[2]]  # half of it below the floor's middle
        shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half)
        turn = pybullet.getQuaternionFromEuler([0.0, 0.0, box.heading])
        number = int(pybullet.createMultiBody(0, shape, basePosition=[*box.place, 0.0], baseOrientation=turn))
        pybullet.changeDynamics(number, -1, lateralFriction=GRIP)
        links = self.scene.links
        meant = {links[name] for name in self.chassis.wheels[box.wheel].links}
        for other in {-1, *links.values()} - meant:
            pybullet.setCollisionFilterPair(self.scene.body, number, other, -1, 0)
        return number

    def driven(self, hooks: Sequence[Hook]) -> Drive:
        period, readings, poses, touches = self.course.period, [], [], []
        nominal, start = self.nominal, self._read()
        gains = INTO / nominal.link if nominal.link else 0.0, HOLD, nominal.link
        offset = np.concatenate((self.course.angles - start[: len(self.driven_by)], np.zeros(3)))
        for row, (speed, rate) in enumerate(self.course.commands):
            read = self._read() + offset
            readings.append(read)
            poses.append(self._poses())
            touches.append([bool(pybullet.getContactPoints(self.scene.body, box)) for box in self.boxes])
            for hook in hooks:
                hook(self.scene, row * period)
            self._command(wheel_ways(nominal.tracks, speed, rate, read[-3:], gains) / nominal.radii)
            self._advance(self.steps)
        table, rows, wheels = np.array(readings), len(readings), len(self.driven_by)
        path = np.array(poses)
        path[:, :, 2] = np.unwrap(path[:, :, 2], axis=0)
        return Drive(
            np.arange(rows, dtype=np.float64) * period,
            table[:, :wheels],
            table[:, wheels:],
            path,
            contacts(np.array(touches, bool).reshape(rows, -1), round(APART / period)),
        )

    def _settle(self) -> None:
        self._command(np.zeros(len(self.driven_by)))
        self._advance(round(SETTLING / self.course.period) * self.steps)

    def _command(self, speeds: Array) -> None:
        for joints, speed in zip(self.driven_by, self.chassis.rolls * speeds, strict=True):
            pybullet.setJointMotorControlArray(
                self.scene.body,
                joints,
                pybullet.VELOCITY_CONTROL,
                targetVelocities=[speed] * len(joints),
                forces=[self.chassis.force] * len(joints),
            )

    def _advance(self, steps: int) -> None:
        tyres, step = self.scene.tyres, pybullet.stepSimulation
        for _ in range(steps):
            if tyres is not None:
                tyres.push(self.scene.body)
            step()

    def _read(self) -> Array:
        """Return the angles of the wheels and of both joints [rad], and the link's length [m]."""
        first = [joints[0] for joints in self.driven_by]
        wheels = [self.chassis.rolls * state[0] for state in pybullet.getJointStates(self.scene.body, first)]
        if not self.linkage:
            return np.array([*wheels, 0.0, 0.0, 0.0])
        a, b, slider = (state[0] for state in pybullet.getJointStates(self.scene.body, self.linkage))
        return np.array([*wheels, -a, b, self.chassis.link + slider])

    def _poses(self) -> list[tuple[float, float, float]]:
        """Return x, y [m] and heading [rad] of each truck."""
        body = self.scene.body
        place, turn = pybullet.getBasePositionAndOrientation(body)
        frames = [pybullet.multiplyTransforms(place, turn, *self.scene.base)]
        if self.linkage:
            frames.append(pybullet.getLinkState(body, self.scene.links["b"], computeForwardKinematics=1)[4:6])
        return [(*place[:2], self._heading(turn)) for place, turn in frames]

    def _heading(self, turn: Sequence[float]) -> float:
        left, matrix = self.chassis.aside, pybullet.getMatrixFromQuaternion(turn)
        ahead = left[1], -left[0]
        if matrix[8] < UPRIGHT:
            raise TippedError(f"the {self.chassis.name} fell over")
        x, y = (matrix[3 * row] * ahead[0] + matrix[3 * row + 1] * ahead[1] for row in (0, 1))
        return math.atan2(y, x)


def _scene(chassis: Chassis, ground: int, height: float) -> Scene:
    turn = pybullet.getQuaternionFromEuler([0.0, 0.0, -math.atan2(-chassis.aside[0], chassis.aside[1])])
    with tempfile.NamedTemporaryFile("w", suffix=".urdf", encoding="utf-8") as file:
        file.write(chassis.urdf)
        file.flush()
        flags = pybullet.URDF_USE_INERTIA_FROM_FILE  # else it is guessed from shapes, which are gone
        body = pybullet.loadURDF(file.name, [0.0, 0.0, height], turn, flags=flags)
    known = [pybullet.getJointInfo(body, number) for number in range(pybullet.getNumJoints(body))]
    links = {info[12].decode(): number for number, info in enumerate(known)}
    joints = {info[1].decode(): number for number, info in enumerate(known)}
    for number in range(-1, len(known)):
        pybullet.changeDynamics(body, number, linearDamping=0.0, angularDamping=0.0)
    rolling = [links[name] for wheel in chassis.wheels.values() for name in wheel.links]
    grip = dict.fromkeys(rolling, chassis.grip) | {
        links[name]: grip_of for name, grip_of in chassis.feet.items()
    }
    tyres = None if chassis.creep is None else Tyres(grip, chassis.creep)
    for number, friction in grip.items():
        pybullet.changeDynamics(body, number, lateralFriction=friction if tyres is None else 0.0)
    for name, number in joints.items():
        if name in chassis.free:
            pybullet.setJointMotorControl2(body, number, pybullet.VELOCITY_CONTROL, force=0.0)
        elif known[number][2] != pybullet.JOINT_FIXED:
            pybullet.setJointMotorControl2(body, number, pybullet.POSITION_CONTROL, 0.0, force=HOLDING)
    inertial = pybullet.getDynamicsInfo(body, -1)[3:5]
    return Scene(body, ground, links, joints, tyres, pybullet.invertTransform(*inertial))
