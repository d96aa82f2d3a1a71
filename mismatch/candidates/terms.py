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

from omnimate.effects import EFFECTS, effect_named
from omnimate.effects.block import LINKAGE
from omnimate.effects.effect import POSES
from omnimate.mismatch.candidates.beliefs import BELIEFS
from omnimate.mismatch.recording.signals import START_ROUGHNESS, WINDOW, grid, is_dense, is_turned

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from omnimate.effects.effect import Effect
    from omnimate.mismatch.diagnosis import Key
    from omnimate.mismatch.recording.signals import Signals
    from omnimate.vehicle.parameters import TruckName
    from omnimate.vehicle.se2 import Array

ANGLES = ("phase", "direction")  # parameters that make a wave of two columns of the one before them
# What bends is tried at several sizes, in a-priori ones: a wide play is no stretched narrow one.
BENT: dict[str, tuple[float, ...]] = {
    "joint_backlash": (1.0, 4.0, 10.0),
    "gear_backlash": (1.0, 6.0),
    "latency": (1.0, 4.0),
}
# What acts on a channel's motion, or on turns, needs motion that the drive makes.
MOVING = {"latency", "clock_drift", "joint_backlash"}
TURNING = {"turn_scrub"}
CLEAR = 10.0
SWINGS = (0.0, 0.05, 0.15)  # [m] over which castors swing round: a few of their own trails
SYNCED = 10.0  # times rarer than a drift of poses: an encoder that answers SYNC has no clock of its own
SKEW = 5e-4  # [s] by which devices sample apart though they answer one SYNC: an interrupt, a short filter
SETUP = "reference_offset"  # how poses are measured; no fault of a robot, and always fitted
BESIDE = 1.0  # [s] about what acts for a while, in which what else happened is what its law leaves
SCANNED = {"bump", "slip_patch", "radius_step", "gear_harmonic"}  # proposed where the recording shows them


@dataclass(frozen=True, slots=True)
class Term:
    """A candidate at fixed values of what is not linear.

    Attributes:
        effect: of the vocabulary.
        component: on which it acts.
        probes: effects of a-priori size, one for each column.
        fixed: parameters that the coefficients do not tell.
        odds: log odds a priori.
        positive: a coefficient below zero makes no sense.
        size: of the probes, in a-priori ones; coefficients are in a-priori sizes whatever it is.
    """

    effect: str
    component: str
    probes: tuple[Effect, ...]
    fixed: dict[str, Any]
    odds: float
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
        if self.effect == SETUP:
            values = {
                own.name: own.scale * float(value)
                for own, value in zip(kind.parameters, coefficients, strict=True)
            }
        elif turned is not None:
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

    def at(self, **fixed: Any) -> Term:  # noqa: ANN401
        """Return the term with other values of what is not linear, and the same odds."""
        return replace(term(self.effect, self.component, **{**self.fixed, **fixed}), odds=self.odds)

    @property
    def is_event(self) -> bool:
        """Whether it is at moments, of which a component may have several."""
        return "times" in self.fixed

    @property
    def is_local(self) -> bool:
        """Whether it acts, or begins, at a place or time."""
        return bool({"times", "time", "intervals"} & self.fixed.keys())

    @property
    def stretches(self) -> list[tuple[float, float]]:
        """From when to when it acts [s]; empty for what acts, once it is there, to the end."""
        return [*((time, time) for time in self.fixed.get("times", ())), *self.fixed.get("intervals", ())]

    @property
    def happening(self) -> list[tuple[float, float]]:
        """From when to when it acts, or comes about if it then lasts to the end [s]."""
        begun = [(self.fixed["time"],) * 2] if "time" in self.fixed else []
        return [*self.stretches, *begun]

    @property
    def most(self) -> float:
        """Declared sizes beyond which nobody believes in it."""
        return BELIEFS[self.effect].most

    @property
    def ordinary(self) -> float:
        """What any robot meets of it at some moment, in declared sizes: no column is everyday for that."""
        return 0.0

    @property
    def inexact(self) -> float:
        """Part by which it may act otherwise than its law says, on any stretch."""
        return BELIEFS[self.effect].inexact

    @property
    def held(self) -> float | None:
        """Its size, where that is known, and is not fitted with those of others."""
        return None

    def fine(self) -> Term:
        """Return the term with probes of a-priori size, as slopes about what was found."""
        if self.size == 1.0:
            return self
        return replace(term(self.effect, self.component, **self.fixed), odds=self.odds)

    @property
    def linear(self) -> str:
        """The parameter that its coefficients tell."""
        return effect_named(self.effect).parameters[0].name if self.effect != "bump" else "lost"


def is_near(time: Array, stretches: Sequence[tuple[float, float]]) -> NDArray[np.bool_]:
    """Say which times (V,) [s] are in some stretches, or shortly before or after."""
    near = np.zeros(len(time), bool)
    for start, end in stretches:
        near |= (time > start - BESIDE) & (time < end + BESIDE)
    return near


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
    elif effect == SETUP:
        probes = tuple(kind(component=component, **{own.name: own.scale}) for own in kind.parameters)
    elif turned is not None:
        probes = tuple(
            kind(component=component, **{linear.name: linear.scale, turned: angle}, **fixed)
            for angle in (0.0, 0.5 * math.pi)
        )
    else:
        probes = (kind(component=component, **{linear.name: null + size * linear.scale}, **fixed),)
    own_clock = effect != "clock_drift" or component in POSES
    bare = BELIEFS[effect].log_odds - (0.0 if own_clock else math.log(SYNCED))
    odds = bare - math.log(tries) * len(fixed.get("times", (0,)))
    positive = linear.low >= null and turned is None and effect != SETUP
    return Term(effect, component, probes, dict(fixed), odds, positive, size)


def angle_of(kind: type[Effect]) -> str | None:
    """Return the parameter that turns a wave, or None for an effect that is none."""
    return next((one.name for one in kind.parameters if one.name in ANGLES), None)


def smooth_terms(signals: Sequence[Signals]) -> list[Term]:
    """Return the terms of all effects that need not be looked for at a place or time."""
    present = components_of(signals[0])
    if not any(one.poses is not None for one in signals):
        present -= {"poses"}
    moved, turned = moving_channels(signals), turns(signals)
    terms = []
    for kind in filter(attrgetter("searched"), EFFECTS):
        for component in kind.components:
            if component not in present or kind.name in SCANNED or kind.name == "law":
                continue
            if kind.name in MOVING and component in LINKAGE and component not in moved:
                continue
            if kind.name in TURNING and not turned:
                continue
            if kind.name == "count_loss":
                speeds = _speeds(signals, component)
                terms += [term(kind.name, component, len(speeds), above=speed) for speed in speeds]
            elif kind.name == "floor_slope":
                terms += [term(kind.name, component, 2, pace=pace) for pace in (0.0, _pace(signals))]
            elif kind.name == "castor_kick":
                terms += [term(kind.name, component, len(SWINGS), swing=swing) for swing in SWINGS]
            else:
                sizes = BENT.get(kind.name, (1.0,))
                terms += [term(kind.name, component, len(sizes), size) for size in sizes]
    return terms


def mounted_terms(signals: Sequence[Signals]) -> list[Term]:
    """Return the terms of how references are mounted, on every truck whose whole pose is measured.

    Nobody mounts a reference on the middle of an axle to a millimetre. What it then shows in turns is no
    fault, however seldom it is measured.
    """
    return [term(SETUP, truck) for truck in _measured(signals, often=False)]


def calibrated_terms(signals: Sequence[Signals]) -> list[Term]:
    """Return the terms of what is calibrated in any case.

    They are how references are mounted, and, of every truck whose whole pose is measured often, its wheelbase
    and its diameters.
    """
    trucks = _measured(signals, often=True)
    return [
        *mounted_terms(signals),
        *(term("wheelbase", truck) for truck in trucks),
        *(term("wheel_diameter", f"{truck}.{side}") for truck in trucks for side in ("left", "right")),
    ]


def _measured(signals: Sequence[Signals], *, often: bool) -> list[TruckName]:
    """Return the trucks whose whole pose is measured often, or at least in several directions."""
    return [
        truck
        for truck in signals[0].trucks
        if any(
            is_dense(own) or (is_turned(own) and not often)
            for own in (one.poses.of(truck) for one in signals if one.poses is not None)
        )
    ]


def moving_channels(signals: Sequence[Signals]) -> set[str]:
    """Return the linkage channels that the drive moves by more than a floor's roughness and a count do.

    What moves a channel otherwise is noise, and truck b's answer to it: a delay or a play of such a
    channel cannot be told from the answer, and what depends on its reading depends on the reading's noise.
    """
    if not signals[0].reading.shape[1]:
        return set()
    jitter, base = _jitter(signals), float(signals[0].block.wheelbase[0])
    readings = np.concatenate([one.reading - one.reading.mean(axis=0) for one in signals])
    sizes = np.hypot((jitter / base, jitter / base, jitter), signals[0].resolution / math.sqrt(12.0))
    return {
        name
        for name, size, own in zip(LINKAGE, sizes, readings.std(axis=0), strict=True)
        if own > CLEAR * size
    }


def turns(signals: Sequence[Signals]) -> bool:
    """Say whether the drive turns the robot by more than a floor's roughness does."""
    least = CLEAR * math.sqrt(2.0) * _jitter(signals) / float(signals[0].block.wheelbase[0])
    yaw = [np.add.reduceat(one.block.twist[:, 0, 2], grid(one.time)[:-1]) for one in signals]
    return float(np.concatenate(yaw).std()) > least


def _jitter(signals: Sequence[Signals]) -> float:
    """Return what the roughness of an ordinary floor adds to a wheel's travel in a window [m]."""
    way = np.concatenate([np.abs(one.block.travel).mean(axis=1) for one in signals]).sum()
    span = sum(float(one.time[-1] - one.time[0]) for one in signals)
    return START_ROUGHNESS * math.sqrt(WINDOW * way / span)


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
