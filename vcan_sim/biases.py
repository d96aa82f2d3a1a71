"""Constant biases of the linkage's encoders, which the plant applies as shifts of their zeros."""

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
    """Return the effects of biased encoders; none for a bias of 0.

    Args:
        joint_a: Reading of joint_a minus its true angle [rad].
        joint_b: Reading of joint_b minus its true angle [rad].
        link: Reading of the link minus its true length [m].
    """
    joints = JointBias("joint_a", joint_a), JointBias("joint_b", joint_b)
    return tuple(bias for bias in (*joints, LinkBias("link", link)) if bias.bias)


def split_biases(effects: Sequence[Effect]) -> tuple[tuple[float, float, float], tuple[Effect, ...]]:
    """Return the biases of joint_a [rad], joint_b [rad] and link [m], and the remaining effects.

    A bias that acts before all other effects on the readings only shifts the zero of an encoder, so that the
    compiled plant can apply it. A bias after another effect remains an effect.
    """
    reading = by_stage(effects)["reading"]
    shifts = tuple(takewhile(lambda effect: isinstance(effect, (JointBias, LinkBias)), reading))
    total = dict.fromkeys(LINKAGE, 0.0)
    for effect in shifts:
        total[effect.component] += effect.values()["bias"]
    remaining = tuple(effect for effect in effects if not any(effect is shift for shift in shifts))
    return (total["joint_a"], total["joint_b"], total["link"]), remaining
