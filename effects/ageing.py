"""Aged samples: base class of effects in which a sensor sends the value of an earlier time.

Latency and clock drift are subclasses; they differ in the age of the samples only.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from omnimate.effects.block import LINKAGE, wheel_number
from omnimate.effects.effect import JOINT, LINK, POSES, WHEEL, Array, Block, Effect, Stage

SYNC_SKEW = 5e-4  # [s] spread of sampling times on one SYNC: interrupt and input filter (assumption)


@dataclass(frozen=True, slots=True)
class History:
    """The last samples of a channel."""

    start: float  # time of the very first sample [s]
    time: Array  # times of the samples that are still needed, `(H,)` [s]
    value: Array  # values of these samples, `(H,)`
    shown: float  # last value that was sent


@dataclass(frozen=True, slots=True)
class AgedSamples(Effect):
    """An effect that makes the samples of one channel, or the poses, older."""

    stage: ClassVar[Stage] = "reading"
    components: ClassVar[tuple[str, ...]] = (*WHEEL, *JOINT, *LINK, *POSES)

    def age(self, time: Array, start: float) -> Array:
        """Return the age of samples `(K,)` [s] at times [s]; the drive began at `start` [s]."""
        raise NotImplementedError

    def acts_at(self) -> Stage:
        """Return the stage of the channel: a wheel's samples age at its encoder, measured poses outside."""
        if self.component in WHEEL:
            return "encoder"
        return "reading" if self.component in LINKAGE else "poses"

    def act(self, block: Block, state: Any = None) -> tuple[Block, Any]:  # noqa: ANN401
        """Show the value of an earlier time; before the first sample, the first one."""
        if self.component in LINKAGE:
            channel = LINKAGE.index(self.component)
            shown, state = self._shown(block, block.reading[:, channel], block.reading[0, channel], state)
            return block.with_reading(channel, shown), state
        if self.component in WHEEL:
            wheel = wheel_number(self.component)
            before = block.angle[0, wheel] - block.turned[0, wheel]
            last = before if state is None else state.shown
            shown, state = self._shown(block, block.angle[:, wheel], before, state)
            return block.with_counted(wheel, shown, np.diff(shown, prepend=last)), state
        return block, state

    def _shown(
        self, block: Block, value: Array, before: float, state: History | None
    ) -> tuple[Array, History]:
        if state is None:
            first = float(block.time[0] - block.period[0])
            state = History(first, np.array([first]), np.array([before]), before)
        time, values = np.concatenate((state.time, block.time)), np.concatenate((state.value, value))
        age = self.age(block.time, state.start)
        # a negative age is extrapolated along the last step
        steps = np.diff(values)[-len(block) :] / np.diff(time)[-len(block) :]
        shown = np.interp(block.time - np.maximum(age, 0.0), time, values) + np.maximum(-age, 0.0) * steps
        oldest = int(np.searchsorted(time, block.time[-1] - age[-1], side="right")) - 1
        kept = slice(max(min(oldest, len(time) - 2), 0), None)
        return shown, History(state.start, time[kept], values[kept], float(shown[-1]))

    def recover(self, block: Block) -> Block:
        """Return the block of a whole recording with the wheel's travel shifted to its true time."""
        if self.component not in WHEEL:
            return block
        wheel = wheel_number(self.component)
        start = float(block.time[0] - block.period[0])
        time = np.concatenate(([start], block.time))
        distance = np.concatenate(([0.0], np.cumsum(block.travel[:, wheel])))
        shifted = np.interp(time + self.age(time, start), time, distance)
        return block.with_travel(wheel, np.diff(shifted))


@dataclass(frozen=True, slots=True)
class Younger(AgedSamples):
    """The opposite of an effect that ages samples: each is the value of as much later a time.

    It is for whole recordings, in which later values are known.
    """

    than: AgedSamples  # the effect

    name = "younger"
    parameters = ()

    def age(self, time: Array, start: float) -> Array:
        """Return the age of samples [s], which is negative."""
        return -self.than.age(time, start)

    def _shown(
        self, block: Block, value: Array, before: float, state: History | None
    ) -> tuple[Array, History]:
        start = float(block.time[0] - block.period[0])
        time, values = np.concatenate(([start], block.time)), np.concatenate(([before], value))
        shown = np.interp(block.time - self.age(block.time, start), time, values)
        return shown, state or History(start, time, values, float(shown[-1]))
