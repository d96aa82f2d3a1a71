"""What an effect is: a piece of physics on one component, at one stage of the signal path.

The order of the stages is that of `STAGES`; `stages` has a picture of the path and what follows it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from omnimate.effects.block import LINKAGE, truck_number, wheels_of
from omnimate.effects.errors import EffectError
from omnimate.effects.words import component_in_words

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.effects.block import Block
    from omnimate.vehicle.parameters import VehicleParameters
    from omnimate.vehicle.se2 import Array

Stage = Literal["encoder", "travel", "body", "reading", "poses"]
STAGES: tuple[Stage, ...] = ("encoder", "travel", "body", "reading", "poses")

WHEEL = ("a.left", "a.right", "b.left", "b.right")
TRUCK = ("a", "b")
JOINT = ("joint_a", "joint_b")
LINK = ("link",)
POSES = ("poses",)

# How a diagnosis finds what is not linear in an effect: by windows that stand out, by the begin and end of an
# interval, by the moment of a lasting step, by the order of a periodic error, by a threshold of speed.
Scan = Literal["moments", "interval", "step", "order", "threshold"]
# Motion without which an effect on a linkage channel, or on a truck, cannot be identified.
Excitation = Literal["channel motion", "turns"]
# When an effect is a nuisance of the first estimate of noise: in any recording, or in one with poses.
Startup = Literal["always", "with poses"]
# Quantity over which the error that an effect explains is plotted.
Abscissa = Literal["time", "wheel angle", "joint angle", "heading", "link length", "speed", "turn rate"]

# Prior odds. With the Bayes factor's own penalty they let noise be named as one of a robot's eight
# calibrated numbers in one recording of two hundred, and as one of its sixty faults likewise: one false
# alarm in a hundred.
MISCALIBRATED = 0.03  # that a calibrated number is wrong: what calibrations are for
FAULT = 0.005  # of a fault of one component
RARE = 0.002  # of a fault that few workshops have met
# A law is off by its discrepancy on each stretch; over a recording of ten or more stretches, by a third.
RECORDING_PART = 0.3


@dataclass(frozen=True, slots=True)
class Parameter:
    """What one parameter of an effect is.

    Attributes:
        name: Name of the effect's field.
        unit: SI unit of the value; "1" for a ratio.
        null: Value at which the effect does nothing; None where no value alone does that.
        scale: Standard deviation of the value's distance from null, in robots that work.
        low: Least value that makes sense.
        high: Greatest value that makes sense.
    """

    name: str
    unit: str
    null: float | None
    scale: float
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class Text:
    """What a field of an effect that is no number means.

    Attributes:
        name: Name of the effect's field.
        about: What may stand there.
    """

    name: str
    about: str


@dataclass(frozen=True, slots=True)
class Prior:
    """What is assumed of an effect before a recording is seen, in units of its parameter's `scale`.

    Attributes:
        odds: Prior odds that one component of a robot has it as a fault.
        background: Standard deviation of what every robot has of it.
        discrepancy: Relative error of its law on any stretch of 4 s, one standard deviation.
        largest: Size beyond which it is rejected: three standard deviations of a large fault, or less where
            nothing in use is as bad.
    """

    odds: float
    background: float = 0.05
    discrepancy: float = 0.05
    largest: float = 15.0

    @property
    def log_odds(self) -> float:
        """Logarithm of the prior odds."""
        return math.log(self.odds)


@dataclass(frozen=True, slots=True)
class Drive:
    """How recordings drive one component, for the values at which an effect is tried.

    Attributes:
        speeds: Quantiles of a wheel's speed between its slowest and fastest [m/s]; empty but for wheels.
        pace: Mean speed of the trucks, pauses included [m/s].
    """

    speeds: Sequence[float]
    pace: float


@dataclass(frozen=True, slots=True)
class Effect:
    """An effect on one component; each kind is a subclass in a file of its own, with all that is known of it.

    Signal path: `stage`, `components`, `parameters` (numbers) and `texts` (other fields).

    Diagnosis: `searched` says whether the kind is a candidate at all, `prior` how likely it is and how large,
    `linear` the parameter that is estimated (the first one by default), `sizes` those at which a nonlinear
    law is linearised, `scan` and `grid` where its other parameters are looked for, `excited_by` the motion
    that it needs. `calibrated` numbers stand in vehicle.toml; a `relative` effect shows only by its
    difference between components; `is_setup` marks how a measurement is arranged: always fitted, no fault.

    Words: `regime` in which it shows, the drive that separates it from others, its sentence (`says`, a
    template of its parameters, or `describe`), `plotted_over`, and what a large one is confused with
    (`alternatives`).

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

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401  each effect keeps another state
        """Return the block with the effect in it, and what the next block has to know.

        Args:
            block: Steps as the stage before left them.
            state: What `act` returned for the block before; None at the start.
        """
        raise NotImplementedError

    def recover(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Return the block with what the wheels really rolled, where angle and turn are as counted.

        Only effects on wheel encoders do that; for all others nothing is to be recovered.
        """
        return block, state

    def acts_during(self, block: Block) -> tuple[float, float] | None:  # noqa: ARG002  few have an end
        """Return from when to when the effect changes the motion of wheels and trucks at most [s].

        None if it does so all the time, or changes anything else.

        Args:
            block: Steps of the robot.
        """
        return None

    @classmethod
    def estimated(cls) -> Parameter:
        """Return the parameter that a diagnosis estimates linearly."""
        return next(one for one in cls.parameters if one.name == (cls.linear or cls.parameters[0].name))

    @classmethod
    def grid(cls, drive: Drive) -> Sequence[dict[str, float]]:  # noqa: ARG003  few depend on it
        """Return the values of the other parameters at which the effect is tried in any recording.

        None where it is tried only at what a scan finds.
        """
        return () if cls.scan else ({},)

    @classmethod
    def log_odds(cls, component: str) -> float:  # noqa: ARG003  few depend on it
        """Return the logarithm of the prior odds that a component has the effect."""
        return cls.prior.log_odds

    @classmethod
    def background(cls, component: str) -> float:  # noqa: ARG003  few depend on it
        """Return the standard deviation of what every robot has of it at a component, in scales."""
        return 0.0 if cls.scan else cls.prior.background

    @classmethod
    def in_any_robot(cls, component: str, vehicle: VehicleParameters) -> Effect | None:  # noqa: ARG003
        """Return what a component of every robot has of a law that is not linear: a nuisance of its own."""
        return None

    def discrepancy(self) -> float:
        """Return by what part the effect's size may be off over a recording, one standard deviation."""
        return RECORDING_PART * self.prior.discrepancy

    def describe(self, vehicle: VehicleParameters) -> str:  # noqa: ARG002  few depend on it
        """Return in a sentence what the effect does, with values in millimetres, degrees and percent."""
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
        for wheel in wheels_of(self.component):
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
