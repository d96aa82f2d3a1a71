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
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from omnimate.effects import CALIBRATED, EFFECTS, effect_named
from omnimate.effects.block import LINKAGE
from omnimate.effects.effect import RARE, Drive, Effect, Prior
from omnimate.mismatch.recording.signals import START_ROUGHNESS, WINDOW, grid, is_dense, is_turned

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from omnimate.mismatch.diagnosis import Key
    from omnimate.mismatch.recording.signals import Signals
    from omnimate.vehicle.parameters import TruckName
    from omnimate.vehicle.se2 import Array

ANGLES = ("phase", "direction")  # parameters that make a wave of two columns of the one before them
UNKNOWN = "unknown"  # what an error is called for which the library has no name
EXCITED = 10.0
EVENT_MARGIN = 1.0  # [s] about what acts for a while, in which what else happened is what its law leaves


class Unknown(Effect):
    """An error for which the library has no name, and no law."""

    name: ClassVar[str] = UNKNOWN
    prior: ClassVar[Prior] = Prior(RARE, background=0.0, discrepancy=0.1)


@dataclass(frozen=True, slots=True)
class Term:
    """A candidate at fixed values of what is not linear."""

    effect: str  # of the vocabulary
    component: str  # on which it acts
    probes: tuple[Effect, ...]  # effects of a-priori size, one for each column
    fixed: dict[str, Any]  # parameters that are not coefficients
    odds: float  # log odds a priori
    positive: bool  # a coefficient below zero makes no sense
    size: float = 1.0  # of the probes, in a-priori ones; coefficients are in a-priori sizes whatever it is

    @property
    def key(self) -> Key:
        """What it is called."""
        return self.effect, self.component

    def built(self, coefficients: Array) -> Effect:
        """Return the effect that has these coefficients `(k,)`."""
        kind = self.kind
        linear, turned = self.linear, angle_of(kind)
        spec = {parameter.name: parameter for parameter in kind.parameters}
        values: dict[str, Any]
        if kind.is_setup:
            values = {
                parameter.name: parameter.scale * float(value)
                for parameter, value in zip(kind.parameters, coefficients, strict=True)
            }
        elif turned is not None:
            size = spec[linear].scale * math.hypot(coefficients[0], coefficients[1])
            angle = math.atan2(coefficients[1], coefficients[0])
            values = {linear: min(size, spec[linear].high), turned: angle}
        elif self.is_event:
            parameter = spec[linear]
            sizes = np.clip(coefficients * parameter.scale, parameter.low, parameter.high)
            values = {linear: tuple(sizes.tolist())}
        else:
            parameter = spec[linear]
            value = (parameter.null or 0.0) + parameter.scale * float(coefficients[0])
            values = {linear: min(max(value, parameter.low), parameter.high)}
        return kind(component=self.component, **self.fixed, **values)

    def sigmas(self, effect: Effect, covariance: Array) -> dict[str, float | tuple[float, ...]]:
        """Return standard deviations of an effect's parameters, by the covariance (k, k) of its coefficients.

        They include the uncertainty of the coefficients, and the discrepancy of the effect's law.
        """
        if self.kind.is_setup:
            parameters = effect.parameters
            sigmas = np.sqrt(np.diag(covariance)).tolist()
            return {one.name: one.scale * sigma for one, sigma in zip(parameters, sigmas, strict=True)}
        spec = next(one for one in effect.parameters if one.name == self.linear)
        value = getattr(effect, self.linear)
        inexact = effect.discrepancy()
        angle_name = angle_of(type(effect))
        if angle_name is not None:
            size, angle = max(value / spec.scale, 1e-9), getattr(effect, angle_name)
            along = np.array([math.cos(angle), math.sin(angle)])
            across = np.array([-math.sin(angle), math.cos(angle)])
            size_sigma = spec.scale * math.sqrt(float(along @ covariance @ along))
            angle_sigma = math.sqrt(float(across @ covariance @ across)) / size
            return {
                self.linear: math.hypot(size_sigma, inexact * value),
                angle_name: min(math.hypot(angle_sigma, inexact), math.pi),
            }
        deviations = spec.scale * np.sqrt(np.diag(covariance))
        if self.is_event:
            return {self.linear: tuple(np.hypot(deviations, inexact * np.asarray(value)).tolist())}
        return {self.linear: math.hypot(float(deviations[0]), inexact * (value - (spec.null or 0.0)))}

    def at(self, **fixed: Any) -> Term:  # noqa: ANN401
        """Return the term with other values of what is not linear, and the same odds."""
        return replace(term(self.effect, self.component, **{**self.fixed, **fixed}), odds=self.odds)

    @property
    def kind(self) -> type[Effect]:
        """The kind of effect of the library, or `Unknown`."""
        return Unknown if self.is_unknown else effect_named(self.effect)

    @property
    def is_unknown(self) -> bool:
        """Whether it is an error for which the library has no name."""
        return self.effect == UNKNOWN

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
    def active_intervals(self) -> list[tuple[float, float]]:
        """From when to when it acts, or comes about if it then lasts to the end [s]."""
        begun = [(self.fixed["time"],) * 2] if "time" in self.fixed else []
        return [*self.stretches, *begun]

    @property
    def largest(self) -> float:
        """Declared sizes beyond which nobody believes in it."""
        return self.kind.prior.largest

    @property
    def nuisance_size(self) -> float:
        """What any robot meets of it at some moment, in declared sizes: less counts for nothing."""
        return 0.0

    @property
    def ordinary_size(self) -> float:
        """The same of what has a name: less is no fault, and counts in full against its rivals."""
        return self.kind.prior.background if self.is_event else 0.0

    @property
    def discrepancy(self) -> float:
        """Part by which it may act otherwise than its law says, on any stretch."""
        return self.kind.prior.discrepancy

    @property
    def held(self) -> float | None:
        """Its size, where that is known, and is not fitted with those of others."""
        return None

    def fine(self) -> Term:
        """Return the term with probes of a-priori size, as slopes about what was found."""
        return self if self.size == 1.0 else self.at()

    @property
    def linear(self) -> str:
        """The parameter of which the coefficients are."""
        return self.kind.estimated().name


def is_near(time: Array, stretches: Sequence[tuple[float, float]]) -> NDArray[np.bool_]:
    """Say which times (V,) [s] are in some stretches, or shortly before or after."""
    near = np.zeros(len(time), bool)
    for start, end in stretches:
        near |= (time > start - EVENT_MARGIN) & (time < end + EVENT_MARGIN)
    return near


def term(effect: str, component: str, tries: int = 1, size: float = 1.0, **fixed: Any) -> Term:  # noqa: ANN401
    """Return a term; `tries` is among how many values its fixed ones, or its size, were looked for."""
    kind = effect_named(effect)
    linear, turned = kind.estimated(), angle_of(kind)
    null = linear.null or 0.0
    if kind.scan == "moments":
        pairs: list[dict[str, Any]] = [
            {"times": (time,), linear.name: (linear.scale,)} for time in fixed["times"]
        ]
        probes = tuple(kind(component=component, **pair) for pair in pairs)
    elif kind.is_setup:
        probes = tuple(
            kind(component=component, **{parameter.name: parameter.scale}) for parameter in kind.parameters
        )
    elif turned is not None:
        probes = tuple(
            kind(component=component, **{linear.name: linear.scale, turned: angle}, **fixed)
            for angle in (0.0, 0.5 * math.pi)
        )
    else:
        probes = (kind(component=component, **{linear.name: null + size * linear.scale}, **fixed),)
    odds = kind.log_odds(component) - math.log(tries) * len(fixed.get("times", (0,)))
    positive = linear.low >= null and turned is None and not kind.is_setup
    return Term(effect, component, probes, dict(fixed), odds, positive, size)


def angle_of(kind: type[Effect]) -> str | None:
    """Return the parameter that turns a wave, or None for an effect that is none."""
    return next((one.name for one in kind.parameters if one.name in ANGLES), None)


def smooth_terms(signals: Sequence[Signals]) -> list[Term]:
    """Return the terms of all effects that need not be looked for at a place or time."""
    vehicle = signals[0].recording.vehicle
    with_poses = any(one.poses is not None for one in signals)
    present = {*vehicle.wheels, *vehicle.trucks, *vehicle.channels, *(("poses",) if with_poses else ())}
    moved, turned, pace = moving_channels(signals), turns(signals), _pace(signals)
    terms = []
    for kind in filter(attrgetter("searched"), EFFECTS):
        for component in kind.components:
            if component not in present:
                continue
            if kind.excited_by == "channel motion" and component in LINKAGE and component not in moved:
                continue
            if kind.excited_by == "turns" and not turned:
                continue
            grid = kind.grid(Drive(_speeds(signals, component), pace))
            tries = len(grid) * len(kind.sizes)
            terms += [
                term(kind.name, component, tries, size, **fixed) for fixed in grid for size in kind.sizes
            ]
    return terms


def mounted_terms(signals: Sequence[Signals]) -> list[Term]:
    """Return the terms of how references are mounted, on every truck whose whole pose is measured.

    Nobody mounts a reference on the middle of an axle to a millimetre. What it then shows in turns is no
    fault, however seldom it is measured.
    """
    trucks = _measured(signals, often=False)
    return [term(kind.name, truck) for kind in EFFECTS if kind.is_setup for truck in trucks]


def calibrated_terms(signals: Sequence[Signals]) -> list[Term]:
    """Return the terms of what is calibrated in any case.

    They are how references are mounted, and the numbers of vehicle.toml of every truck whose whole pose is
    measured often.
    """
    trucks = _measured(signals, often=True)
    return [
        *mounted_terms(signals),
        *(
            term(kind.name, component)
            for kind in CALIBRATED
            for component in kind.components
            if component[0] in trucks
        ),
    ]


def _measured(signals: Sequence[Signals], *, often: bool) -> list[TruckName]:
    """Return the trucks whose whole pose is measured often, or at least in several directions."""
    return [
        truck
        for truck in signals[0].trucks
        if any(
            is_dense(poses) or (is_turned(poses) and not often)
            for poses in (one.poses.of(truck) for one in signals if one.poses is not None)
        )
    ]


def moving_channels(signals: Sequence[Signals]) -> set[str]:
    """Return the linkage channels that the drive moves by more than a floor's roughness and a count do.

    What moves a channel otherwise is noise, and truck b's answer to it: a delay or a play of such a
    channel looks the same as the answer, and what depends on its reading depends on the reading's noise.
    """
    if not signals[0].reading.shape[1]:
        return set()
    jitter, base = _jitter(signals), float(signals[0].block.wheelbase[0])
    readings = np.concatenate([one.reading - one.reading.mean(axis=0) for one in signals])
    sizes = np.hypot((jitter / base, jitter / base, jitter), signals[0].resolution / math.sqrt(12.0))
    return {
        name
        for name, size, deviation in zip(LINKAGE, sizes, readings.std(axis=0), strict=True)
        if deviation > EXCITED * size
    }


def turns(signals: Sequence[Signals]) -> bool:
    """Say whether the drive turns the robot by more than a floor's roughness does."""
    least = EXCITED * math.sqrt(2.0) * _jitter(signals) / float(signals[0].block.wheelbase[0])
    yaw = [np.add.reduceat(one.block.twist[:, 0, 2], grid(one.time)[:-1]) for one in signals]
    return float(np.concatenate(yaw).std()) > least


def _jitter(signals: Sequence[Signals]) -> float:
    """Return what the roughness of an ordinary floor adds to a wheel's travel in a window [m]."""
    distance = np.concatenate([np.abs(one.block.travel).mean(axis=1) for one in signals]).sum()
    span = sum(float(one.time[-1] - one.time[0]) for one in signals)
    return START_ROUGHNESS * math.sqrt(WINDOW * distance / span)


def _speeds(signals: Sequence[Signals], component: str) -> list[float]:
    """Return speeds [m/s] between those that a wheel was driven at; none for other components."""
    wheels = [str(wheel) for wheel in signals[0].wheels]
    if component not in wheels:
        return []
    number = wheels.index(component)
    speed = np.concatenate([np.abs(one.block.speed[:, number]) for one in signals])
    speed = speed[speed > 0.02]
    if len(speed) == 0:
        return [0.05]
    return sorted(
        {round(float(value), 3) for value in np.quantile(speed, [0.02, 0.15, 0.35, 0.6, 0.8, 0.92])}
    )


def _pace(signals: Sequence[Signals]) -> float:
    """Return the trucks' mean speed forward or back [m/s], pauses and all."""
    distance = sum(float(np.abs(one.block.twist[:, :, 0]).mean(axis=1).sum()) for one in signals)
    return round(distance / sum(float(one.time[-1] - one.time[0]) for one in signals), 3)
