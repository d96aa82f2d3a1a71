"""Programs of driving: where the leading truck should be at each moment, as arrays on the control clock."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Curvature = Callable[[NDArray[np.float64]], NDArray[np.float64]]

EIGHT = 2.404825557695773  # first zero of the Bessel function J0: the eight closes


@dataclass(frozen=True, slots=True)
class Program:
    """What to drive, with a row for each control period.

    Attributes:
        protocol: Name of the protocol in `run.toml`.
        side: Side of UMBmark's square [m]; None for other drives.
        v: Speed of the leading truck [m/s], shape `(N,)`.
        w: Turn rate of the leading truck [rad/s], shape `(N,)`.
        leader: Truck that leads, "a" or "b", shape `(N,)`.
        laps: Laps as (direction, first row, last row).
    """

    protocol: str
    side: float | None
    v: NDArray[np.float64]
    w: NDArray[np.float64]
    leader: NDArray[np.str_]
    laps: tuple[tuple[str, int, int], ...]

    def first(self, laps: int) -> Program:
        """Return the program up to the end of its first laps."""
        end = self.laps[laps - 1][2]
        return Program(
            self.protocol, self.side, self.v[:end], self.w[:end], self.leader[:end], self.laps[:laps]
        )


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
    leader = np.where(program.v < 0, "b", "a")
    return Program("straight", None, program.v, program.w, leader, program.laps)


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
