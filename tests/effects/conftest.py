"""A drive as a block of steps, and what an effect makes of it."""

import itertools

import numpy as np
import pytest

from omnimate.effects.block import Block

PERIOD, START = 0.015, 1000.0
CHANGED = ("angle", "turned", "travel", "twist", "reading")


def drive(steps=400):
    """Four wheels that speed up, slow down and reverse, each in its own time; joints and link that swing."""
    time = START + PERIOD * np.arange(1, steps + 1)
    since = time - START
    phase = np.outer(since, [1.1, 1.3, 0.9, 1.2])
    speed, acceleration = 0.4 * np.sin(phase), 0.4 * np.array([1.1, 1.3, 0.9, 1.2]) * np.cos(phase)
    turned = speed * PERIOD / 0.075
    wave = np.stack([np.sin(since), np.cos(1.1 * since), 1.0 + 0.01 * np.sin(3.0 * since)], axis=1)
    return Block(
        time=time,
        period=np.full(steps, PERIOD),
        angle=5.0 + np.cumsum(turned, axis=0),
        turned=turned,
        speed=speed,
        acceleration=acceleration,
        wheelbase=np.array([0.340, 0.340]),
        heading=np.stack([0.5 * since, -0.3 * since], axis=1),
        place=np.stack([wave[:, :2], wave[:, 1:]], axis=1),
        travel=0.075 * turned,
        twist=np.zeros((steps, 2, 3)),
        reading=wave,
        rest=1.0,
    ).rolled()


def acted(effect, block, cuts=()):
    """Return the signals that an effect makes of a block that it gets in pieces."""
    state, parts, edges = None, [], [0, *sorted(cuts), len(block)]
    for start, end in itertools.pairwise(edges):
        if start == end:
            continue
        part, state = effect.act(block.between(start, end), state)
        parts.append(part)
    return {name: np.concatenate([getattr(part, name) for part in parts]) for name in CHANGED}


@pytest.fixture(scope="session", name="block")
def block_fixture():
    return drive()


@pytest.fixture(scope="session", name="acted")
def acted_fixture():
    return acted
