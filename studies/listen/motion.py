"""How a robot drives about: what its wheels, joints and slider do over time."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.random import Generator

from omnimate.vehicle.se2 import Array

STEP = 0.005  # [s]


@dataclass
class Motion:
    """Angles and lengths over time."""

    time: Array  # times [s], shape `(N,)`
    wheels: dict[str, Array]  # angle of each wheel over time by its channel, forward positive [rad]
    joints: dict[str, Array] = field(default_factory=dict)  # angle of each joint over time [rad]
    link: Array | None = None  # length of the link [m]; None for one truck


def drive(random: Generator, seconds: float, trucks: int) -> Motion:
    """Return a drive of straights, arcs, turns on the spot and stops."""
    time = np.arange(0.0, seconds, STEP)
    top = math.exp(random.uniform(math.log(0.15), math.log(2.0)))
    wheelbase = random.uniform(0.25, 0.9)
    speed, turn = commands(random, len(time), top, wheelbase, spot=trucks == 1)
    base = {"a": wheelbase, "b": wheelbase * (1.0 if random.random() < 0.7 else random.uniform(0.9, 1.1))}
    diameter = random.uniform(0.08, 0.4)
    wheels = _wheels(speed, turn, "a", base["a"], diameter, random)
    if trucks == 1:
        return Motion(time, wheels)
    follow = _follow(random, speed, turn)
    wheels |= _wheels(follow[0], follow[1], "b", base["b"], diameter, random)
    return Motion(time, wheels, {"joint_a": follow[2], "joint_b": follow[3]}, follow[4])


def commands(random: Generator, count: int, top: float, wheelbase: float, *, spot: bool) -> Iterator[Array]:
    """Return speed [m/s] and rate of turn [rad/s], each limited in its change."""
    speed, turn = np.zeros(count), np.zeros(count)
    at = 0 if random.random() < 0.5 else int(random.uniform(0.5, 8.0) / STEP)
    kinds = ["straight", "arc", "stop", "back"] + (["spot"] * 2 if spot else [])
    shares = random.dirichlet(np.ones(len(kinds))) + 0.08
    shares[0] += 0.3
    shares /= shares.sum()
    while at < count:
        end = at + int(random.uniform(1.0, 8.0) / STEP)
        kind = random.choice(kinds, p=shares)
        going = top * random.uniform(0.3, 1.0)
        if kind == "straight":
            speed[at:end] = going
        elif kind == "back":
            speed[at:end] = -0.5 * going
        elif kind == "arc":
            speed[at:end] = going
            turn[at:end] = going / random.uniform(1.5, 8.0) / wheelbase / 2 * random.choice([-1, 1])
        elif kind == "spot":
            turn[at:end] = 2 * going / wheelbase * random.uniform(0.3, 0.8) * random.choice([-1, 1])
        at = end
    rise = random.uniform(0.1, 0.8)  # [s]
    width = max(int(rise / STEP), 3)
    window = np.hanning(width + 2)[1:-1]
    window /= window.sum()
    limit = min(1.2, 1.6 * top / wheelbase)
    turn = np.clip(turn, -limit, limit)
    return (np.convolve(each, window)[:count] for each in (speed, turn))


def _wheels(
    speed: Array, turn: Array, truck: str, base: float, diameter: float, random: Generator
) -> dict[str, Array]:
    radius = {side: diameter / 2 * random.normal(1.0, 0.003) for side in ("left", "right")}
    wobble = np.convolve(random.normal(0, 1, len(speed)), np.ones(40) / 40, "same")
    speed = speed * (1 + 0.01 * wobble)
    rate = {
        "left": (speed - turn * base / 2) / radius["left"],
        "right": (speed + turn * base / 2) / radius["right"],
    }
    return {f"{truck}.{side}": np.cumsum(each) * STEP for side, each in rate.items()}


def _follow(random: Generator, speed: Array, turn: Array) -> Array:
    """Return speed and rate of turn of the truck behind, both joints, and the link's length."""
    count = len(speed)
    rest = random.uniform(0.5, 1.6)
    gain, pull = random.uniform(0.8, 2.5), random.uniform(0.8, 3.0)
    out = np.zeros((5, count))
    ax, ay, ah, bx, by, bh = rest, 0.0, 0.0, 0.0, 0.0, 0.0
    for n in range(count):
        dx, dy = ax - bx, ay - by
        length, direction = math.hypot(dx, dy), math.atan2(dy, dx)
        joint_a = math.remainder(ah - direction, 2 * math.pi)
        joint_b = math.remainder(bh - direction, 2 * math.pi)
        v = speed[n] * math.cos(joint_a) + pull * (length - rest)
        w = -gain * joint_b + speed[n] * math.sin(joint_a) / rest * 0.5
        out[:, n] = v, w, joint_a, joint_b, length
        ah += turn[n] * STEP
        ax += speed[n] * math.cos(ah) * STEP
        ay += speed[n] * math.sin(ah) * STEP
        bh += w * STEP
        bx += v * math.cos(bh) * STEP
        by += v * math.sin(bh) * STEP
    return out
