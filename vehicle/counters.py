"""Raw counters to counts that never wrap: one law, live and over a whole recording.

A counter of range N is known only modulo N, so the shortest way from one reading to the next is taken,
in either direction. A step that no robot can make is rejected: the channel is not present in that
sample and keeps its last count. When the next reading goes on from the rejected one, the counter has
really moved (a restart without a boot-up message): a wheel is re-baselined there, so that it does not
jump (`omnimate.vehicle.bridging` says what it may have lost); an absolute encoder (joint, link) is believed.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from omnimate.vehicle.parameters import Encoder, VehicleParameters

MAX_SPEED = 10.0  # [m/s] of a wheel or of the slider; no floor robot is faster
MAX_TURN_RATE = 20.0  # [rad/s] of a joint; likewise


def samples_left_out(passed: ArrayLike, vehicle: VehicleParameters) -> NDArray[np.int64]:
    """Return how many samples there could have been between two that are `passed` seconds apart."""
    periods = np.rint(np.asarray(passed, np.float64) / vehicle.bus.sync_period)
    return np.maximum(periods - 1.0, 0.0).astype(np.int64)


@dataclass(frozen=True, slots=True)
class CounterLaw:
    """How one encoder's raw readings follow each other.

    Attributes:
        periods: Ranges [counts] modulo which a step is taken, in this order.
        max_step: Largest step per sample that is believed [counts], below half of every range.
        absolute: True where a reading means a place (joint, link), False where it means travel (wheel).
        below_half: Largest step that is not half of a range or more [counts].
    """

    periods: tuple[int, ...]
    max_step: int
    absolute: bool
    below_half: int = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "below_half", (min(self.periods) + 1) // 2 - 1)

    def step(self, before: int, after: int) -> int:
        """Return the shortest way from one raw reading to the next [counts]."""
        delta = after - before
        for period in self.periods:
            delta = (delta + period // 2) % period - period // 2
        return delta

    def believes(self, step: int, samples: int = 1) -> bool:
        """Say whether a step is possible within a number of samples."""
        return abs(step) <= min(self.max_step * samples, self.below_half)


def counter_law(encoder: Encoder, vehicle: VehicleParameters) -> CounterLaw:
    """Return the law of one encoder of a vehicle.

    A joint that counts whole turns wraps at its turn (single-turn encoders) or at its width; taking the
    step modulo the width and then modulo the turn is right for both.
    """
    periods: tuple[int, ...] = (encoder.wrap_range,)
    period = vehicle.bus.sync_period
    if encoder.channel == "link":
        return CounterLaw(periods, _counts(MAX_SPEED * period / abs(encoder.scale)), absolute=True)
    if encoder.channel in {"joint_a", "joint_b"}:
        turn = encoder.counts_per_turn
        if turn is not None and float(turn).is_integer():
            periods = (encoder.wrap_range, int(turn))
        return CounterLaw(periods, _counts(MAX_TURN_RATE * period / abs(encoder.scale)), absolute=True)
    metres = abs(vehicle.metres_per_count(encoder.channel))
    return CounterLaw(periods, _counts(MAX_SPEED * period / metres), absolute=False)


def _counts(step: float) -> int:
    return max(1, int(step))


class Counter:
    """One encoder's counter, followed reading by reading.

    Attributes:
        count: Unwrapped count of the last reading that was believed; None before the first.
        rebased: The last reading was one of a counter that had begun anew.
    """

    def __init__(self, law: CounterLaw) -> None:
        self.law = law
        self.count: int | None = None
        self.rebased = False
        self._raw = 0
        self._suspect: int | None = None
        self._samples = 0
        self._rebase = False

    def step(self, raw: int | None) -> bool:
        """Take the reading of one sample, None where it is missing; say whether it was believed."""
        self._samples += 1
        self.rebased = False
        if raw is None:
            return False
        if self.count is None:
            self.count = raw
        elif self._rebase and not self.law.absolute:
            self.rebased = True  # this reading is where the old count goes on
        else:
            step = self.law.step(self._raw, raw)
            if not self.law.believes(step, self._samples):
                restarted = self._suspect is not None and self.law.believes(self.law.step(self._suspect, raw))
                if not restarted:
                    self._suspect = raw
                    return False
                self.rebased = not self.law.absolute
            self.count += 0 if self.rebased else step
        self._raw, self._suspect, self._samples, self._rebase = raw, None, 0, False
        return True

    def skip(self, samples: int) -> None:
        """Note that so many samples could not be taken, while the counter may have gone on."""
        self._samples += samples

    def correct(self, counts: int) -> None:
        """Add counts that the encoder has lost."""
        if self.count is not None:
            self.count += counts

    def rebase(self) -> None:
        """Let the next reading stand where the last one stood: the device has been restarted."""
        self._rebase = True


@dataclass(frozen=True, slots=True)
class Unwrapped:
    """One channel over a recording.

    Attributes:
        counts: (N,) unwrapped; a sample that is not present repeats the one before it, and the samples
            before the first present one show that one.
        present: Readings that were there and were believed, shape `(N,)`.
        rebased: Readings at which a wheel's counter had begun anew, shape `(N,)`.
    """

    counts: NDArray[np.int64]
    present: NDArray[np.bool_]
    rebased: NDArray[np.bool_]


def unwrap(
    raw: ArrayLike,
    law: CounterLaw,
    present: ArrayLike | None = None,
    restarts: ArrayLike | None = None,
    left_out: ArrayLike | None = None,
) -> Unwrapped:
    """Unwrap a whole channel: what `Counter` gives reading by reading.

    Args:
        raw: (N,) raw readings; the values where `present` is False do not matter.
        law: How the encoder's readings follow each other.
        present: Where a reading was received, shape `(N,)`; everywhere by default.
        restarts: (N,) True where the device restarted since the sample before.
        left_out: Samples that could not be taken before each one, shape `(N,)`; none by default.
    """
    raw = np.asarray(raw, np.int64)
    present = np.ones(len(raw), bool) if present is None else np.array(present, bool)
    restarts = np.zeros(len(raw), bool) if restarts is None else np.asarray(restarts, bool)
    left_out = np.zeros(len(raw), np.int64) if left_out is None else np.asarray(left_out, np.int64)
    where = np.flatnonzero(present)
    if len(where) == 0:
        return Unwrapped(np.zeros(len(raw), np.int64), present, np.zeros(len(raw), bool))
    steps = np.diff(raw[where])
    for period in law.periods:
        steps = (steps + period // 2) % period - period // 2
    rebased = np.zeros(len(raw), bool)
    if not law.absolute:
        begun = np.diff(np.cumsum(restarts)[where]) > 0
        steps[begun] = 0
        rebased[where[1:][begun]] = True
    limit = np.minimum(law.max_step * np.diff(where + np.cumsum(left_out)[where]), law.below_half)
    if np.any(np.abs(steps) > limit):
        return _reading_by_reading(raw, law, present, restarts, left_out)
    counts = raw[where[0]] + np.concatenate(([0], np.cumsum(steps)))
    return Unwrapped(counts[np.maximum(np.cumsum(present) - 1, 0)], present, rebased)


def _reading_by_reading(
    raw: NDArray[np.int64],
    law: CounterLaw,
    present: NDArray[np.bool_],
    restarts: NDArray[np.bool_],
    left_out: NDArray[np.int64],
) -> Unwrapped:
    """Unwrap a channel with rejected readings, which is rare, by the stepwise law itself."""
    counter = Counter(law)
    believed, rebased = np.zeros(len(raw), bool), np.zeros(len(raw), bool)
    counts = np.empty(len(raw), np.int64)
    for index, value in enumerate(raw.tolist()):
        if restarts[index]:
            counter.rebase()
        counter.skip(int(left_out[index]))
        believed[index] = counter.step(value if present[index] else None)
        counts[index] = counter.count if counter.count is not None else 0
        rebased[index] = counter.rebased
    first = int(np.argmax(believed))
    counts[:first] = counts[first]
    return Unwrapped(counts, believed, rebased)
