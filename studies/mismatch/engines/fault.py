"""A fault that an engine conceals: an effect, its parameters, and what it remembers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

Ground = tuple[str, float, float]  # a wheel, and its place on the floor [m]


@dataclass(slots=True)
class ConcealedFault:
    """A fault in a robot, with its state.

    Attributes:
        effect: Name of the effect in the vocabulary, or "unknown".
        component: Component on which it acts.
        parameters: Parameters of the effect, by name.
        memory: State that the fault keeps from step to step; empty at the start of a drive.
    """

    effect: str
    component: str
    parameters: dict[str, Any]
    memory: dict[str, Any] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Any:  # noqa: ANN401  numbers or lists of them
        return self.parameters[name]
