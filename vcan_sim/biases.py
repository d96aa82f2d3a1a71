"""Constant biases of the linkage's encoders: effects that the plant can add as shifts of their zeros."""

from __future__ import annotations

from itertools import takewhile
from typing import TYPE_CHECKING

from omnimate.effects.block import LINKAGE
from omnimate.effects.joint_bias import JointBias
from omnimate.effects.link_bias import LinkBias
from omnimate.effects.stages import by_stage

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.effects.effect import Effect


def linkage_biases(joint_a: float = 0.0, joint_b: float = 0.0, link: float = 0.0) -> tuple[Effect, ...]:
    """Return the effects of encoders that read too much; a bias of 0 needs none.

    Args:
        joint_a: What joint_a reads too much [rad].
        joint_b: What joint_b reads too much [rad].
        link: What the link reads too much [m].
    """
    joints = JointBias("joint_a", joint_a), JointBias("joint_b", joint_b)
    return tuple(bias for bias in (*joints, LinkBias("link", link)) if bias.bias)


def split_biases(effects: Sequence[Effect]) -> tuple[tuple[float, float, float], tuple[Effect, ...]]:
    """Return the biases of joint_a [rad], joint_b [rad] and link [m], and the effects that are left.

    A bias that acts before any other effect on the readings shifts an encoder's zero and does nothing
    else, so that the compiled plant can add it. A later one has to wait for its turn and stays an effect.
    """
    reading = by_stage(effects)["reading"]
    shifts = tuple(takewhile(lambda effect: isinstance(effect, (JointBias, LinkBias)), reading))
    total = dict.fromkeys(LINKAGE, 0.0)
    for effect in shifts:
        total[effect.component] += effect.values()["bias"]
    left = tuple(effect for effect in effects if not any(effect is shift for shift in shifts))
    return (total["joint_a"], total["joint_b"], total["link"]), left
