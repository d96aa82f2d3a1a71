"""Programs of driving, as arrays on the control clock, and the controller of the MuJoCo robot.

One truck follows the program by odometry, the other follows the link. The controller knows the readings of
the encoders and the nominal robot. It knows no true pose.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from studies.mismatch.engines.true_motion import Nominal

Curvature = Callable[[NDArray[np.float64]], NDArray[np.float64]]

EIGHT = 2.404825557695773  # first zero of the Bessel function J0: the eight closes


@dataclass(frozen=True, slots=True)
class Program:
    """What to drive, with a row for each control period."""

    protocol: str  # name of the protocol in `run.toml`
    side: float | None  # side of UMBmark's square [m]; None for other drives
    v: NDArray[np.float64]  # speed of the leading truck [m/s], shape `(N,)`
    w: NDArray[np.float64]  # turn rate of the leading truck [rad/s], shape `(N,)`
    leader: NDArray[np.str_]  # truck that leads, "a" or "b", shape `(N,)`
    laps: tuple[tuple[str, int, int], ...]  # laps as (direction, first row, last row)

    def first(self, laps: int) -> Program:
        """Return the program up to the end of its first laps."""
        end = self.laps[laps - 1][2]
        return replace(self, v=self.v[:end], w=self.w[:end], leader=self.leader[:end], laps=self.laps[:laps])


class Pace:
    """Speeds and accelerations of a program, and its control period [s]."""

    def __init__(self, dt: float, speed: float, turn: float = 1.0) -> None:
        self.dt, self.speed, self.turn = dt, speed, turn

    def ramp(self, way: float, top: float, gain: float) -> NDArray[np.float64]:
        """Return a smooth speed profile [m/s] that covers a distance `way` [m] exactly."""
        top = min(top, np.sqrt(abs(way) * gain))
        duration = abs(way) / top + top / gain
        t = np.arange(self.dt, duration + self.dt, self.dt)
        rise = np.clip(np.minimum(t, duration - t) * gain / top, 0, 1)
        shape = rise * rise * (3 - 2 * rise)
        return np.asarray(shape * way / (shape.sum() * self.dt))

    def stretch(self, way: float, bend: Curvature | None = None) -> NDArray[np.float64]:
        """Return rows (v, w) of a path of length `way` [m] with a curvature [1/m] at each place on it."""
        v = self.ramp(way, self.speed, 0.35)
        place = np.cumsum(v) * self.dt - v * self.dt / 2
        return np.stack([v, v * bend(place) if bend else 0 * v], axis=1)

    def spin(self, angle: float) -> NDArray[np.float64]:
        """Return rows (v, w) of a turn on the spot [rad]."""
        w = self.ramp(angle, self.turn, 1.5)
        return np.stack([0 * w, w], axis=1)

    def rest(self, seconds: float) -> NDArray[np.float64]:
        """Return rows (v, w) of standing."""
        return np.zeros((round(seconds / self.dt), 2))


def square(pace: Pace, side: float, turns: tuple[int, ...]) -> Program:
    """Return UMBmark's square with turns on the spot; `turns` holds +1 (ccw) or -1 (cw) for each lap."""
    laps = []
    for sign in turns:
        leg = [pace.stretch(side), pace.rest(0.3), pace.spin(sign * np.pi / 2), pace.rest(0.3)]
        laps.append((_word(sign), np.concatenate(leg * 4)))
    return _program("umbmark", side, pace, laps)


def rounded(pace: Pace, side: float, turns: tuple[int, ...]) -> Program:
    """Return squares with round corners, driven without stops; `turns` is as in `square`."""
    corner = 0.7 * side

    def bend(sign: int) -> Curvature:
        def curvature(s: NDArray[np.float64]) -> NDArray[np.float64]:
            into = s % side - (side - corner) / 2
            round_ = (into > 0) & (into < corner)
            return np.asarray(
                sign * np.pi / 2 / corner * np.where(round_, 1 - np.cos(2 * np.pi * into / corner), 0)
            )

        return curvature

    laps = [(_word(sign), pace.stretch(4 * side, bend(sign))) for sign in turns]
    return _program("extended-umbmark", None, pace, laps)


def eight(pace: Pace, length: float, laps: int) -> Program:
    """Return figures of eight of a given length, whose heading swings by 2.4 rad to both sides."""

    def curvature(s: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(EIGHT * 2 * np.pi / length * np.cos(2 * np.pi * s / length))

    return _program("free", None, pace, [("none", pace.stretch(length, curvature))] * laps)


def shuttle(pace: Pace, way: float, laps: int) -> Program:
    """Return straight drives out with truck a leading, and back in reverse with truck b leading."""
    out, back = pace.stretch(way), pace.stretch(-way)
    rows = np.concatenate([out, pace.rest(0.5), back])
    program = _program("straight", None, pace, [("none", rows)] * laps)
    return replace(program, leader=np.where(program.v < 0, "b", "a"))


def _word(sign: int) -> str:
    return "ccw" if sign > 0 else "cw"


def _program(
    protocol: str, side: float | None, pace: Pace, laps: list[tuple[str, NDArray[np.float64]]]
) -> Program:
    """Return laps in one program, with a stop before, between and after them."""
    rows, spans, row = [pace.rest(1.0)], [], len(pace.rest(1.0))
    for direction, lap in laps:
        spans.append((direction, row, row + len(lap)))
        rows += [lap, pace.rest(1.0)]
        row += len(lap) + len(pace.rest(1.0))
    v, w = np.concatenate(rows).T
    return Program(protocol, side, v, w, np.full(len(v), "a"), tuple(spans))


WEAVING = 9.0  # [s] in which the following truck turns to one side of the link and the other
KX, KY, KTHETA, KLINK, KJOINT = 1.0, 6.0, 2.5, 1.5, 1.5


@dataclass(slots=True)
class Controller:
    """Odometry of both trucks and the wheel speeds that keep them on their path."""

    nominal: Nominal  # the robot as it is described
    dt: float  # control period [s]
    weave: float = 0.0  # amplitude with which the following truck swings about the link [rad]
    time: float = 0.0  # time driven so far, without the stops [s]
    # pose of the leading truck that the program asks for [m, m, rad], shape `(3,)`
    goal: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    # poses of both trucks by odometry, shape `(2, 3)`
    pose: NDArray[np.float64] = field(default_factory=lambda: np.zeros((2, 3)))
    # last wheel angles [rad], shape `(4,)`; None before the first step
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

        The program asks a speed [m/s] and a turn rate [rad/s] of the leading truck, 0 or 1; read are the
        angles of wheels and joints [rad], and the link's length [m].
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
