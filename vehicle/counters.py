"""Unwrapping of raw counters, as one compiled step that recordings loop over.

A counter of range N is known only modulo N, so the shortest step between two readings is used. A step that
no robot can make is rejected: the channel is not present in that sample and keeps its last count. If the next
reading continues from the rejected one, the counter has really moved (a restart without a boot-up message): a
wheel is re-baselined there without a jump (`omnimate.vehicle.bridging` estimates the lost travel); an
absolute encoder (joint, link) is accepted. After so many lost samples that it may have moved by half of its
range or more, `omnimate.vehicle.bridging` adds the ranges that a wheel has passed.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated

import numpy as np

from omnimate.vehicle.compiled import IntArray, Record, compiled, layout

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike

    from omnimate.vehicle.parameters import Encoder, VehicleParameters

MAX_SPEED = 10.0  # [m/s] of a wheel or the slider; assumption: no floor robot is faster
MAX_TURN_RATE = 20.0  # [rad/s] of a joint; assumption: no floor robot is faster


@dataclass(frozen=True, slots=True)
class CounterLaw:
    """Ranges and largest step of one encoder's raw counter."""

    periods: tuple[int, ...]  # ranges [counts] modulo which a step is taken, one or two, in this order
    max_step: int  # largest step per sample that is accepted [counts], below half of every range
    absolute: bool  # True for a position (joint, link), False for travel (wheel)
    below_half: int = field(init=False)  # largest step that is not half of a range or more [counts]

    def __post_init__(self) -> None:
        object.__setattr__(self, "below_half", (min(self.periods) + 1) // 2 - 1)


class Counter:
    """Record of one encoder's counter; the first five fields are its law."""

    periods: Annotated[IntArray, 2]  # ranges modulo which a step is taken [counts]; 0 for none, or for 2^64
    max_step: int  # largest step per sample that is accepted [counts]
    below_half: int  # largest step that is not half of a range or more [counts]
    is_absolute: bool  # whether a reading is a position (joint, link), not travel (wheel)
    count: int  # unwrapped count of the last accepted reading; 0 before the first
    raw: int  # that reading
    suspect: int  # the reading after it that was rejected
    samples: int  # samples since the last accepted reading
    # samples of which the travel is not known: half of the range or more, or a restart; `bridging` resets it
    ambiguous: int
    is_known: bool  # whether a reading has been accepted
    is_suspect: bool  # whether the last reading was rejected
    has_restarted: bool  # whether the device has restarted since the last accepted reading
    present: bool  # whether a reading was accepted in this sample
    rebased: bool  # whether it was one of a wheel's counter that had restarted


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


def counters_of(laws: Sequence[CounterLaw], fields: type = Counter) -> Record:
    """Return one record per counter `(C,)`, before its first reading; `fields` may be a class with more."""
    counters = np.zeros(len(laws), layout(fields))
    for counter, law in zip(counters, laws, strict=True):
        for place, period in enumerate(law.periods):
            counter["periods"][place] = period if period < 2**63 else 0
        counter["max_step"] = min(law.max_step, law.below_half)
        counter["below_half"] = law.below_half
        counter["is_absolute"] = law.absolute
    return counters


@compiled
def shortest_step(counter: Counter, before: int, after: int) -> int:
    """Return the shortest step from one raw reading to the next [counts]."""
    step = after - before
    for period in counter.periods:
        if period > 0:
            step = (step + period // 2) % period - period // 2
    return step


@compiled
def is_possible(counter: Counter, step: int, samples: int) -> bool:
    """Return whether a counter can make a step [counts] within a number of samples."""
    return abs(step) <= counter.below_half and (abs(step) - 1) // counter.max_step < samples


@compiled
def take_reading(counter: Counter, raw: int) -> None:
    """Process the reading of a sample; call it after `begin_sample`."""
    step = 0
    if not counter.is_known:
        counter.count = raw
    elif counter.has_restarted and not counter.is_absolute:
        counter.rebased = True  # this reading is where the old count goes on
    else:
        step = shortest_step(counter, counter.raw, raw)
        if not is_possible(counter, step, counter.samples):
            if not (
                counter.is_suspect and is_possible(counter, shortest_step(counter, counter.suspect, raw), 1)
            ):
                counter.suspect, counter.is_suspect = raw, True
                return
            counter.rebased = not counter.is_absolute
            if counter.rebased:
                step = 0
    if counter.rebased or counter.samples > counter.below_half // counter.max_step:
        counter.ambiguous += counter.samples
    counter.count += step
    counter.raw, counter.samples = raw, 0
    counter.is_known, counter.is_suspect, counter.has_restarted, counter.present = True, False, False, True


@compiled
def begin_sample(counter: Counter) -> None:
    """Begin a sample; `take_reading` may follow."""
    counter.samples += 1
    counter.present, counter.rebased = False, False


@compiled
def take_readings(counters: Record, raw: IntArray) -> None:
    """Process the readings `(C,)` of one sample in which every counter was read."""
    for number in range(len(counters)):
        begin_sample(counters[number])
        take_reading(counters[number], raw[number])


@compiled
def _take_all(counters: Record, raw: IntArray, counts: IntArray) -> None:
    """Process all readings `(N,)` of one counter, and fill its counts, shape `(N,)`."""
    for row in range(len(raw)):
        take_readings(counters, raw[row : row + 1])
        counts[row] = counters[0].count


def unwrap(raw: ArrayLike, law: CounterLaw) -> IntArray:
    """Return the unwrapped counts `(N,)` of a counter that was read in each sample: raw readings `(N,)`."""
    readings = np.asarray(raw, np.int64)
    counts = np.zeros(len(readings), np.int64)
    _take_all(counters_of([law]), readings, counts)
    return counts
