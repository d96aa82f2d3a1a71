"""The candidates: every effect of the library on every component that a robot has.

A term is one candidate as columns of a linear model. Its columns are probes: the effect at the size of
one a-priori standard deviation, so that coefficients have a normal prior of unit size. A wave has two,
a quarter of a turn apart. What is not linear (an order, a moment, intervals) is fixed in the term, and
several terms may stand for the same effect and component.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimate.mismatch.signals import START_ROUGHNESS, WINDOW
from omnimate.vcan_sim.effects import EFFECTS, effect_named
from omnimate.vcan_sim.effects.block import LINKAGE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.mismatch.diagnosis import Key
    from omnimate.mismatch.signals import Signals
    from omnimate.vcan_sim.effects.effect import Effect
    from omnimate.vehicle.se2 import Array

ANGLES = ("phase", "direction")  # parameters that make a wave of two columns of the one before them
# Nobody's numbers are exact: this part of an effect's a-priori size is in every robot, and is no finding.
TOLERATED = {
    "wheel_diameter": 0.01,
    "wheelbase": 0.03,
    "turn_scrub": 0.03,
    "wheel_misalignment": 0.01,
    "lateral_slip": 0.03,
    "traction_slip": 0.03,
    "castor_kick": 0.1,
    "joint_bias": 0.01,
    "link_bias": 0.03,
    "latency": 0.03,
    "clock_drift": 0.1,
    "bump": 0.03,
}
# What bends is tried at several sizes, in a-priori ones: a wide play is no stretched narrow one.
BENT: dict[str, tuple[float, ...]] = {
    "joint_backlash": (1.0, 4.0, 10.0),
    "gear_backlash": (1.0, 6.0),
    "latency": (1.0, 4.0),
}
# What acts on a channel's motion needs motion that the drive makes.
MOVING = {"latency", "clock_drift", "joint_backlash"}
CLEAR = 10.0
FOLLOWED = ("joint_b", "link")
ANSWERED = 12.0  # log odds against a delay or play of what truck b answers to: its answer looks like one
SKEW = 0.3  # of a SYNC period: devices answer SYNC one after the other, and sample a little apart
MOMENTS = "single moments"
SCANNED = {"bump", "slip_patch", "radius_step", "gear_harmonic"}  # proposed where the recording shows them
# What is likelier before anything is seen, as a difference of log probabilities: an owner's numbers are
# off in every robot, while the others are faults that a few have.
_COMMON = {"wheel_diameter": 1.0, "wheelbase": 1.0, "joint_bias": 0.7, "link_bias": 0.7, "bump": 0.5}
_RARE = {
    "clock_drift": -1.0,
    "count_loss": -0.7,
    "link_eccentricity": -0.3,
    "radius_vs_speed": -0.5,
    "turn_scrub": -0.3,
    "gear_harmonic": -0.5,
}


@dataclass(frozen=True, slots=True)
class Term:
    """A candidate at fixed values of what is not linear.

    Attributes:
        effect: of the vocabulary.
        component: on which it acts.
        probes: effects of a-priori size, one for each column.
        fixed: parameters that the coefficients do not tell.
        plausibility: log probability a priori, up to a constant.
        positive: a coefficient below zero makes no sense.
        size: of the probes, in a-priori ones; coefficients are in a-priori sizes whatever it is.
    """

    effect: str
    component: str
    probes: tuple[Effect, ...]
    fixed: dict[str, Any]
    plausibility: float
    positive: bool
    size: float = 1.0

    @property
    def key(self) -> Key:
        """What it is called."""
        return self.effect, self.component

    def built(self, coefficients: Array) -> Effect:
        """Return the effect that has these coefficients `(k,)`."""
        kind = effect_named(self.effect)
        linear, turned = self.linear, angle_of(kind)
        spec = {one.name: one for one in kind.parameters}
        values: dict[str, Any]
        if turned is not None:
            size = spec[linear].scale * math.hypot(coefficients[0], coefficients[1])
            angle = math.atan2(coefficients[1], coefficients[0])
            values = {linear: min(size, spec[linear].high), turned: angle}
        elif linear == "lost":
            lost = np.clip(coefficients * spec["lost"].scale, spec["lost"].low, spec["lost"].high)
            values = {"lost": tuple(lost.tolist())}
        else:
            own = spec[linear]
            value = (own.null or 0.0) + own.scale * float(coefficients[0])
            values = {linear: min(max(value, own.low), own.high)}
        return kind(component=self.component, **self.fixed, **values)

    @property
    def tolerance(self) -> float:
        """How much of its a-priori size is in every robot."""
        return TOLERATED.get(self.effect, 0.0) if self.size == 1.0 else 0.0

    def fine(self) -> Term:
        """Return the term with probes of a-priori size, as slopes about what was found."""
        if self.size == 1.0:
            return self
        return replace(term(self.effect, self.component, **self.fixed), plausibility=self.plausibility)

    @property
    def linear(self) -> str:
        """The parameter that its coefficients tell."""
        return effect_named(self.effect).parameters[0].name if self.effect != "bump" else "lost"


def term(effect: str, component: str, tries: int = 1, size: float = 1.0, **fixed: Any) -> Term:  # noqa: ANN401
    """Return a term; `tries` is among how many values its fixed ones, or its size, were looked for."""
    kind = effect_named(effect)
    linear = next(
        one
        for one in kind.parameters
        if one.name == ("lost" if effect == "bump" else kind.parameters[0].name)
    )
    null, turned = linear.null or 0.0, angle_of(kind)
    if effect == "bump":
        times = fixed["times"]
        pairs: list[dict[str, Any]] = [{"times": (time,), "lost": (linear.scale,)} for time in times]
        probes = tuple(kind(component=component, **pair) for pair in pairs)
    elif turned is not None:
        probes = tuple(
            kind(component=component, **{linear.name: linear.scale, turned: angle}, **fixed)
            for angle in (0.0, 0.5 * math.pi)
        )
    else:
        probes = (kind(component=component, **{linear.name: null + size * linear.scale}, **fixed),)
    plausibility = (
        _COMMON.get(effect, 0.0) + _RARE.get(effect, 0.0) - math.log(tries) * len(fixed.get("times", (0,)))
    )
    if effect in MOVING and component in FOLLOWED:
        plausibility -= ANSWERED
    positive = linear.low >= null and turned is None
    return Term(effect, component, probes, dict(fixed), plausibility, positive, size)


def angle_of(kind: type[Effect]) -> str | None:
    """Return the parameter that turns a wave, or None for an effect that is none."""
    return next((one.name for one in kind.parameters if one.name in ANGLES), None)


def smooth_terms(signals: Sequence[Signals]) -> list[Term]:
    """Return the terms of all effects that need not be looked for at a place or time."""
    present = components_of(signals[0])
    if not any(one.poses is not None for one in signals):
        present -= {"poses"}
    moved = moving_channels(signals)
    terms = []
    for kind in filter(attrgetter("searched"), EFFECTS):
        for component in kind.components:
            if component not in present or kind.name in SCANNED:
                continue
            if kind.name in MOVING and component in LINKAGE and component not in moved:
                continue
            if kind.name == "count_loss":
                speeds = _speeds(signals, component)
                terms += [term(kind.name, component, len(speeds), above=speed) for speed in speeds]
            elif kind.name == "floor_slope":
                terms += [term(kind.name, component, 2, pace=pace) for pace in (0.0, _pace(signals))]
            else:
                sizes = BENT.get(kind.name, (1.0,))
                terms += [term(kind.name, component, len(sizes), size) for size in sizes]
    return terms


def moving_channels(signals: Sequence[Signals]) -> set[str]:
    """Return the linkage channels that the drive moves by more than a floor's roughness does.

    What moves a channel otherwise is noise, and truck b's answer to it: a delay or a play of such a
    channel cannot be told from the answer.
    """
    if not signals[0].reading.shape[1]:
        return set()
    way = np.concatenate([np.abs(one.block.travel).mean(axis=1) for one in signals]).sum()
    span = sum(float(one.time[-1] - one.time[0]) for one in signals)
    jitter = START_ROUGHNESS * math.sqrt(WINDOW * way / span)
    base = float(signals[0].block.wheelbase[0])
    readings = np.concatenate([one.reading - one.reading.mean(axis=0) for one in signals])
    sizes = (jitter / base, jitter / base, jitter)
    return {
        name
        for name, size, own in zip(LINKAGE, sizes, readings.std(axis=0), strict=True)
        if own > CLEAR * size
    }


def components_of(signals: Signals) -> set[str]:
    """Return the components that a robot has."""
    vehicle = signals.recording.vehicle
    return {*vehicle.wheels, *vehicle.trucks, *vehicle.channels, "poses"}


def _speeds(signals: Sequence[Signals], component: str) -> list[float]:
    """Return speeds [m/s] between those that a wheel was driven at, for a loss of counts above one."""
    number = signals[0].recording.vehicle.wheels.index(component)
    speed = np.concatenate([np.abs(one.block.speed[:, number]) for one in signals])
    speed = speed[speed > 0.02]
    if len(speed) == 0:
        return [0.05]
    return sorted(
        {round(float(value), 3) for value in np.quantile(speed, [0.02, 0.15, 0.35, 0.6, 0.8, 0.92])}
    )


def _pace(signals: Sequence[Signals]) -> float:
    """Return the trucks' mean speed forward or back [m/s], pauses and all."""
    way = sum(float(np.abs(one.block.twist[:, :, 0]).mean(axis=1).sum()) for one in signals)
    return round(way / sum(float(one.time[-1] - one.time[0]) for one in signals), 3)


def skews(signals: Signals) -> list[Term]:
    """Return a latency of each encoder, of the part of a SYNC period that devices differ by."""
    kind, part = effect_named("latency"), SKEW * signals.recording.vehicle.bus.sync_period
    return [
        Term("latency", channel, (kind(component=channel, delay=part),), {}, 0.0, positive=False)  # type: ignore[call-arg]
        for channel in signals.recording.vehicle.channels
    ]
