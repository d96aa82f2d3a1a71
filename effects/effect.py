"""The base class of effects: physics of one component at one stage of the signal path.

The order of the stages is that of `STAGES`; `stages` has a picture of the path and what follows it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from omnimate.effects.block import LINKAGE, truck_number, wheel_columns
from omnimate.effects.block import Block as Block  # noqa: PLC0414  # an effect's file takes its types from here
from omnimate.effects.errors import EffectError
from omnimate.effects.words import component_in_words
from omnimate.vehicle.parameters import VehicleParameters as VehicleParameters  # noqa: PLC0414, TC001
from omnimate.vehicle.se2 import Array as Array  # noqa: PLC0414, TC001

if TYPE_CHECKING:
    from collections.abc import Sequence

Stage = Literal["encoder", "travel", "body", "reading", "poses"]
STAGES: tuple[Stage, ...] = ("encoder", "travel", "body", "reading", "poses")

WHEEL = ("a.left", "a.right", "b.left", "b.right")
TRUCK = ("a", "b")
JOINT = ("joint_a", "joint_b")
LINK = ("link",)
POSES = ("poses",)

# How a diagnosis finds the nonlinear parameter of an effect: outlying windows, start and end of an interval,
# time of a lasting step, order of a periodic error, threshold of speed.
Scan = Literal["moments", "interval", "step", "order", "threshold"]
# Motion without which an effect on a linkage channel, or on a truck, cannot be identified.
Excitation = Literal["channel motion", "turns"]
# Recordings in which an effect is a nuisance parameter of the first noise estimate.
Startup = Literal["always", "with poses"]
# Quantity over which the error that an effect explains is plotted.
Abscissa = Literal["time", "wheel angle", "joint angle", "heading", "link length", "speed", "turn rate"]

# Prior odds [1]. Together with the Bayes factor's penalty they limit false alarms from noise to one recording
# in two hundred for the eight calibrated parameters, and likewise for the sixty faults: one in a hundred in
# total.
MISCALIBRATED = 0.03  # a calibrated parameter is wrong
FAULT = 0.005  # one component has a given fault
RARE = 0.002  # one component has a given rare fault
# [1] Discrepancy of a law over a recording, relative to that on one stretch of 4 s: 1 / sqrt(10 stretches).
RECORDING_DISCREPANCY_FACTOR = 0.3


@dataclass(frozen=True, slots=True)
class Parameter:
    """Name, unit and limits of one parameter of an effect."""

    name: str  # of the effect's field
    unit: str  # SI unit of the value; "1" for a ratio
    null: float | None  # value at which the effect vanishes; None if no value of this one alone does that
    scale: float  # unit of `Prior`: typical deviation of the value from null in working robots
    low: float  # smallest valid value
    high: float  # largest valid value


PHASE = Parameter("phase", "rad", null=None, scale=2.0, low=-7.0, high=7.0)


@dataclass(frozen=True, slots=True)
class Text:
    """Name and meaning of a text field of an effect."""

    name: str  # of the effect's field
    about: str  # allowed values


@dataclass(frozen=True, slots=True)
class Prior:
    """Prior of an effect in a diagnosis, in units of its parameter's `scale`."""

    odds: float  # prior odds that one component of a robot has the fault
    background: float = 0.05  # standard deviation of the nominal variation among fault-free robots
    discrepancy: float = 0.05  # relative error of its law on any stretch of 4 s, one standard deviation
    # Size above which an estimate is rejected: three standard deviations of a large fault, or less if no
    # robot in use is that bad
    largest: float = 15.0

    @property
    def log_odds(self) -> float:
        """Logarithm of the prior odds."""
        return math.log(self.odds)


@dataclass(frozen=True, slots=True)
class Drive:
    """Speeds of one component in the recordings, for the grid of trial values of an effect."""

    speeds: Sequence[float]  # quantiles of a wheel's speed, slowest to fastest [m/s]; empty but for wheels
    pace: float  # mean speed of the trucks, pauses included [m/s]


@dataclass(frozen=True, slots=True)
class Effect:
    """An effect on one component; every kind is a subclass in a separate file that holds all its properties.

    Signal path: `stage`, `components`, `parameters` (numbers) and `texts` (other fields).

    Diagnosis: `searched` kinds are candidates; `prior` is their probability and size; `linear` is the
    estimated parameter (default: the first one); `sizes` are the points of linearisation of a nonlinear law;
    `scan` and `grid` give trial values of the other parameters; `excited_by` is the required motion.
    `calibrated` parameters are in vehicle.toml; a `relative` effect is visible only by its difference between
    components; `is_setup` marks properties of the measurement setup, which are always fitted and never a
    fault.

    Report: `regime` in which it is visible, the drive that separates it from others, its sentence (`says`, a
    template of its parameters, or `describe`), `plotted_over`, and `alternatives` to a large value.

    Attributes:
        component: Component on which the effect acts: a wheel, "a" or "b", a joint, "link", or "poses".
    """

    component: str

    name: ClassVar[str]
    stage: ClassVar[Stage]
    components: ClassVar[tuple[str, ...]]
    parameters: ClassVar[tuple[Parameter, ...]]
    texts: ClassVar[tuple[Text, ...]] = ()

    searched: ClassVar[bool] = True
    prior: ClassVar[Prior]
    linear: ClassVar[str] = ""
    sizes: ClassVar[tuple[float, ...]] = (1.0,)
    scan: ClassVar[Scan | None] = None
    excited_by: ClassVar[Excitation | None] = None
    startup_nuisance: ClassVar[Startup | None] = None
    calibrated: ClassVar[bool] = False
    relative: ClassVar[bool] = False
    is_setup: ClassVar[bool] = False

    regime: ClassVar[str] = "always"
    separating_drive: ClassVar[str] = ""
    says: ClassVar[str] = "{part} has this effect."
    plotted_over: ClassVar[Abscissa] = "time"
    alternatives: ClassVar[tuple[str, ...]] = ()

    def __post_init__(self) -> None:
        if self.component not in self.components:
            raise EffectError(
                f"{self.name}: component {self.component!r}; expected one of {', '.join(self.components)}"
            )
        for parameter in self.parameters:
            self._check(parameter)

    def _check(self, parameter: Parameter) -> None:
        for value in _flat(getattr(self, parameter.name)):
            if not parameter.low <= value <= parameter.high:
                raise EffectError(
                    f"{self.name} of {self.component}: {parameter.name} = {value} {parameter.unit}; "
                    f"expected {parameter.low:g} to {parameter.high:g}"
                )

    def acts_at(self) -> Stage:
        """Return the stage at which the effect acts on its component."""
        return self.stage

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401  state differs
        """Return the block after the previous stage with the effect applied, and the next block's state.

        `state` is the one that `act` returned for the previous block; None at the start.
        """
        raise NotImplementedError

    def recover(self, block: Block) -> Block:
        """Return a recording with the true travel, given angle and turn as counted: the inverse of `act`.

        Only effects on wheel encoders have one; all others return the block unchanged.
        """
        return block

    def acts_during(self, block: Block) -> tuple[float, float] | None:  # noqa: ARG002  few have an end
        """Return start and end of the time in which the effect changes the motion of wheels and trucks [s].

        None if it always does, or changes something else.
        """
        return None

    @classmethod
    def estimated(cls) -> Parameter:
        """Return the parameter that a diagnosis estimates linearly."""
        return next(
            parameter
            for parameter in cls.parameters
            if parameter.name == (cls.linear or cls.parameters[0].name)
        )

    @classmethod
    def grid(cls, drive: Drive) -> Sequence[dict[str, float]]:  # noqa: ARG003  few depend on it
        """Return the trial values of the other parameters for any recording.

        Empty if only a scan gives trial values.
        """
        return () if cls.scan else ({},)

    @classmethod
    def log_odds(cls, component: str) -> float:  # noqa: ARG003  few depend on it
        """Return the logarithm of the prior odds that a component has the effect."""
        return cls.prior.log_odds

    @classmethod
    def background(cls, component: str) -> float:  # noqa: ARG003  few depend on it
        """Return the standard deviation of the nominal variation at a component, in units of `scale`."""
        return 0.0 if cls.scan else cls.prior.background

    @classmethod
    def in_any_robot(cls, component: str, vehicle: VehicleParameters) -> Effect | None:  # noqa: ARG003
        """Return the nominal size of a nonlinear effect on a component of any robot; None for none."""
        return None

    def discrepancy(self) -> float:
        """Return the relative error of the effect's law over a recording, one standard deviation."""
        return RECORDING_DISCREPANCY_FACTOR * self.prior.discrepancy

    def describe(self, vehicle: VehicleParameters) -> str:  # noqa: ARG002  few depend on it
        """Return the effect as a sentence, with values in millimetres, degrees and percent."""
        return self.says.format(part=component_in_words(self.component), **_display_values(self))

    def values(self) -> dict[str, Any]:
        """Return the parameters by name."""
        return {field.name: getattr(self, field.name) for field in fields(self) if field.name != "component"}


@dataclass(frozen=True, slots=True)
class WheelEffect(Effect):
    """An effect on the travel of a wheel, or of both wheels of a truck, that remembers nothing."""

    stage: ClassVar[Stage] = "travel"
    components: ClassVar[tuple[str, ...]] = WHEEL

    def travelled(self, block: Block, wheel: int) -> Array:
        """Return the travel `(K,)` of a wheel with the effect in it [m]."""
        raise NotImplementedError

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Change the travel of the component's wheels."""
        for wheel in wheel_columns(self.component):
            block = block.with_travel(wheel, self.travelled(block, wheel))
        return block, state


@dataclass(frozen=True, slots=True)
class TruckEffect(Effect):
    """An effect on the motion of a truck that remembers nothing."""

    stage: ClassVar[Stage] = "body"
    components: ClassVar[tuple[str, ...]] = TRUCK

    def change(self, twist: Array, block: Block, truck: int) -> None:
        """Change the twist `(K, 3)` of a truck in place."""
        raise NotImplementedError

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Change the twist of the truck."""
        truck = truck_number(self.component)
        twist = block.twist[:, truck].copy()
        self.change(twist, block, truck)
        return block.with_twist(truck, twist), state


@dataclass(frozen=True, slots=True)
class ChannelEffect(Effect):
    """An effect on the reading of a joint or the link that remembers nothing."""

    stage: ClassVar[Stage] = "reading"

    def shown(self, block: Block, reading: Array) -> Array:
        """Return the reading `(K,)` of the channel with the effect in it, [rad] or [m]."""
        raise NotImplementedError

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Change the reading of the channel."""
        channel = LINKAGE.index(self.component)
        return block.with_reading(channel, self.shown(block, block.reading[:, channel])), state


def _flat(value: Any) -> tuple[float, ...]:  # noqa: ANN401  a number, or tuples of them
    """Return all numbers in a parameter."""
    if isinstance(value, tuple):
        return tuple(number for part in value for number in _flat(part))
    return (value,)


def _display_values(effect: Effect) -> dict[str, Any]:
    """Return the scalar parameters in mm, degrees and s.

    Each also comes as its deviation from 1 in percent (`_percent`), and times 100 (`_hundredths`).
    """
    shown: dict[str, Any] = {}
    for spec in effect.parameters:
        value = getattr(effect, spec.name)
        if isinstance(value, tuple):
            continue
        factor = {"m": 1e3, "rad": math.degrees(1.0), "s": 1.0}.get(spec.unit, 1.0)
        shown[spec.name] = value * factor
        shown[f"{spec.name}_percent"] = (value - 1.0) * 100.0
        shown[f"{spec.name}_hundredths"] = value * 100.0
    return shown
