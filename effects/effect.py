"""What an effect is: a piece of physics on one component, at one stage of the signal path.

The order of the stages is that of `STAGES`; `stages` has a picture of the path and what follows it.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from omnimate.effects.errors import EffectError

if TYPE_CHECKING:
    from omnimate.effects.block import Block

Stage = Literal["encoder", "travel", "body", "reading", "poses"]
STAGES: tuple[Stage, ...] = ("encoder", "travel", "body", "reading", "poses")

WHEEL = ("a.left", "a.right", "b.left", "b.right")
TRUCK = ("a", "b")
JOINT = ("joint_a", "joint_b")
LINK = ("link",)
POSES = ("poses",)


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
class Effect:
    """An effect on one component; each kind is a subclass in a file of its own.

    `searched` says whether a diagnosis has the kind among its candidates; `texts` are its fields that are no
    numbers.

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

    def values(self) -> dict[str, Any]:
        """Return the parameters by name."""
        return {field.name: getattr(self, field.name) for field in fields(self) if field.name != "component"}


def _flat(value: Any) -> tuple[float, ...]:  # noqa: ANN401  a number, or tuples of them
    """Return all numbers in a parameter."""
    if isinstance(value, tuple):
        return tuple(number for part in value for number in _flat(part))
    return (value,)
