"""The fields of a message as signals, with probabilities and reasons."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from omnimate.listen import priors
from omnimate.listen.code_lengths import little_endian, number_code, to_signed
from omnimate.listen.layout import find_layout, log2_sum, reading_weights
from omnimate.listen.multiplexing import find_multiplexor
from omnimate.listen.profile_words import profile_reading

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from omnimate.files.logs.signals import Signal
    from omnimate.listen.layout import Field, Layout, Reading
    from omnimate.listen.messages import Message
    from omnimate.listen.multiplexing import Multiplexed
    from omnimate.listen.priors import Kind

SURE_PROBABILITY = 0.99  # smallest probability of a finding that is reported as sure: an error rate of 1 %
# Upper limit of the probability of boundaries inside bytes, or in messages outside of CANopen, because only
# `MAX_INNER_EDGES` boundaries inside bytes are tried, and unused bits above a field leave its end open.
# Assumption.
MAX_PACKED_PROBABILITY = 0.9
# Upper limit of the probability of the boundaries of flags of several bytes, and of numbers whose width the
# data do not determine: nine of ten have a common type. Assumption.
MAX_OPEN_PROBABILITY = 0.9
WIDTHS = (8, 16, 32)  # [bits] of the types that nearly all mapped objects have
MAX_LAYOUT_FRAMES = 4096  # frames from which a layout is learned, if every changing bit changes in them
# Share of a frame counter's steps that are equal; the others are lost frames (assumption)
MIN_SAME_STEP_SHARE = 0.98
MAX_COUNTER_STEP = 16  # counts from frame to frame of a frame counter (assumption)
MAX_CLOCK_ERROR = 1e-3  # relative error of a device's clock; quartz is more exact, resonators reach 5e-3

SignalKind = Literal[
    "constant",
    "status word",
    "control word",
    "bits",
    "number",
    "float",
    "counter",
    "time",
    "multiplexor",
    "cannot tell",
]


@dataclass(frozen=True)
class LearnedSignal:
    """A field of a message with its properties and their probabilities."""

    can_id: int  # identifier of the message
    is_extended: bool  # whether it has 29 bits
    node: int  # node that sends or receives it; 0 where that is not known
    start: int  # its lowest bit in the number that all bytes of the message make in its byte order
    bits: int  # its width
    length: int  # length of the message [bytes]
    is_big_endian: bool  # whether its byte order is big-endian
    # probability of start and width [0 to 1]; 1 if SDO traffic showed the mapping
    boundaries_probability: float
    kind: SignalKind  # kind of its content; `cannot tell` if no kind has a probability above 0.5
    kind_probability: float  # probability of the kind, given the boundaries [0 to 1]
    signed: bool | None  # whether it is a two's complement number; None if that is not identified
    counter_range: int  # value at which it restarts from 0 before its bits are full; 0 for none [counts]
    # name of the object by SDO traffic, such as `5.6064h Position actual value`; empty if not known
    name: str
    time: NDArray[np.float64]  # times of its values [s], shape `(N,)`
    raw: NDArray[np.uint64]  # its values as unsigned numbers, shape `(N,)`
    reasons: tuple[str, ...] = field(default=())  # sentences on how it was decided
    # value of the message's multiplexor with which it is sent; None for always
    multiplexor_value: int | None = None

    @property
    def is_sure(self) -> bool:
        """Whether boundaries and kind are reported as sure."""
        return (
            self.kind != "cannot tell"
            and self.boundaries_probability * self.kind_probability >= SURE_PROBABILITY
        )

    @property
    def label(self) -> str:
        """A name that is unique in the log."""
        identifier = f"{self.can_id:08X}" if self.is_extended else f"{self.can_id:03X}"
        multiplexed = "" if self.multiplexor_value is None else f".m{self.multiplexor_value}"
        return f"{identifier}.{self.start}.{self.bits}{'b' if self.is_big_endian else ''}{multiplexed}"

    def values(self) -> NDArray[np.float64]:
        """Return its values as signed, unsigned or floating-point numbers, shape `(N,)`."""
        if self.kind == "float":
            return self.raw.astype(np.uint32).view(np.float32).astype(np.float64)
        if self.signed:
            return to_signed(self.raw, self.bits).astype(np.float64)
        return self.raw.astype(np.float64)

    def unwrapped(self) -> NDArray[np.float64]:
        """Return its values without the jumps where a counter wraps, shape `(N,)`."""
        if self.kind == "float":
            return self.values()
        step = to_signed(np.diff(self.raw), self.bits)
        if self.counter_range:
            step = (step + self.counter_range // 2) % self.counter_range - self.counter_range // 2
        start = float(to_signed(self.raw[:1], self.bits)[0]) if self.signed else float(self.raw[0])
        return start + np.concatenate(([0.0], np.cumsum(step.astype(np.float64))))

    def with_reasons(self, *reasons: str, **changes: Any) -> LearnedSignal:  # noqa: ANN401  # its fields
        """Return a copy with additional reasons and changed attributes."""
        return replace(self, reasons=(*self.reasons, *reasons), **changes)


def learn_signals(message: Message, known: Sequence[Signal]) -> tuple[LearnedSignal, ...]:
    """Return the signals of a message: those of `known` if given, else those of its most probable layout.

    The bytes behind the last field in `known`, the mapping in SDO traffic, are left out.
    """
    if known:
        return tuple(
            _known_signal(message, mapped)
            for mapped in known
            if mapped.start_bit + mapped.bits <= 8 * message.data.shape[1]
        )
    is_canopen = message.node > 0
    layout_of = partial(
        find_layout,
        direction=message.direction,
        big_endian_prior=priors.BIG_ENDIAN if is_canopen else priors.BIG_ENDIAN_ELSEWHERE,
        packed_prior=priors.PACKED if is_canopen else priors.PACKED_ELSEWHERE,
    )
    part = _most_active_frames(message.data)
    layout = layout_of(part)
    multiplexed = find_multiplexor(part, layout, layout_of)
    if multiplexed is None:
        return _signals(message, layout)
    learned = [_multiplexor(message, multiplexed)]
    for value, parts in multiplexed.layouts.items():
        rows = np.flatnonzero(message.data[:, multiplexed.start // 8] == value)
        for first, last, part_layout in parts:
            part_of = replace(message, time=message.time[rows], data=message.data[rows, first:last])
            learned += [
                _moved(signal, value, first, last, message) for signal in _signals(part_of, part_layout)
            ]
    return tuple(learned)


def _moved(signal: LearnedSignal, value: int, first: int, last: int, message: Message) -> LearnedSignal:
    """Return a multiplexed signal of the bytes `first` to `last` - 1 with its start in the whole message."""
    length = message.data.shape[1]
    skipped = length - last if signal.is_big_endian else first
    return replace(signal, multiplexor_value=value, start=signal.start + 8 * skipped, length=length)


def _signals(message: Message, layout: Layout) -> tuple[LearnedSignal, ...]:
    order = max(layout.big_endian_probability, 1.0 - layout.big_endian_probability)
    fields = _merged(layout.fields)
    following = [*(layout_field.bits if _is_constant(layout_field) else 0 for layout_field in fields[1:]), 0]
    return tuple(
        _signal(message, layout_field, order, spare)
        for layout_field, spare in zip(fields, following, strict=True)
    )


def _multiplexor(message: Message, learned: Multiplexed) -> LearnedSignal:
    raw = _column(message, learned.start, 8, is_big_endian=False)
    values = ", ".join(map(str, learned.layouts))
    return _blank(message, learned.start, 8, raw).with_reasons(
        f"the description of the other bytes is shorter if it depends on its values {values}",
        kind="multiplexor",
        kind_probability=SURE_PROBABILITY,
    )


def _most_active_frames(data: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the frames from which a layout is learned: the part with the most changes, or all."""
    if len(data) <= MAX_LAYOUT_FRAMES:
        return data
    moving = np.bitwise_or.reduce(data ^ data[0])
    changes = np.concatenate(([0], np.cumsum(np.any(data[1:] != data[:-1], axis=1))))
    start = int(np.argmax(changes[MAX_LAYOUT_FRAMES - 1 :] - changes[: len(data) - MAX_LAYOUT_FRAMES + 1]))
    part = data[start : start + MAX_LAYOUT_FRAMES]
    return part if np.array_equal(np.bitwise_or.reduce(part ^ part[0]), moving) else data


def _merged(fields: Sequence[Field]) -> list[Field]:
    """Return the fields with neighbouring constant fields merged."""
    merged: list[Field] = []
    for layout_field in fields:
        if merged and _is_constant(layout_field) and _is_constant(merged[-1]):
            last = merged[-1]
            merged[-1] = replace(last, bits=last.bits + layout_field.bits, probability=1.0)
        else:
            merged.append(
                replace(layout_field, probability=1.0)
                if _is_constant(layout_field) and len(fields) > 1
                else layout_field
            )
    return merged


def _width_is_open(raw: NDArray[np.uint64], bits: int, spare: int) -> bool:
    """Return whether the number has the same values with another width of `WIDTHS`.

    It may be narrower if its upper bits never changed, and wider if the `spare` bits above it never changed
    while it did not wrap.
    """
    moved = int(np.bitwise_or.reduce(raw ^ raw[0])).bit_length()
    if any(moved <= width < bits for width in WIDTHS):
        return True
    wraps = np.any(to_signed(np.diff(raw), bits) != np.diff(raw.astype(np.int64)))
    return not wraps and any(bits < width <= bits + spare for width in WIDTHS)


def _is_constant(layout_field: Field) -> bool:
    return max(layout_field.readings, key=lambda reading: layout_field.readings[reading])[0] == "constant"


def _column(message: Message, start: int, bits: int, *, is_big_endian: bool) -> NDArray[np.uint64]:
    data = message.data[:, ::-1] if is_big_endian else message.data
    return little_endian(data) >> np.uint64(start) & np.uint64((1 << bits) - 1)


def _signal(message: Message, layout_field: Field, order: float, spare: int) -> LearnedSignal:
    """Return the signal of a field, above which `spare` bits never change; `order` is a probability."""
    raw = _column(message, layout_field.start, layout_field.bits, is_big_endian=layout_field.is_big_endian)
    kinds = _kinds(layout_field.readings)
    kind = max(kinds, key=lambda name: kinds[name])
    signal = replace(
        _blank(message, layout_field.start, layout_field.bits, raw), is_big_endian=layout_field.is_big_endian
    )
    if kind == "constant":
        return signal.with_reasons(
            _constant_reason(raw),
            kind="constant",
            kind_probability=1.0,
            boundaries_probability=layout_field.probability,
        )
    signal = signal.with_reasons(
        *_layout_reasons(layout_field, kinds, order),
        boundaries_probability=min(
            layout_field.probability * (order if layout_field.bits > 8 else 1.0),
            1.0
            if message.node and layout_field.start % 8 == 0 and layout_field.bits % 8 == 0
            else MAX_PACKED_PROBABILITY,
            MAX_OPEN_PROBABILITY if kind == "bits" and layout_field.bits > 8 else 1.0,
            MAX_OPEN_PROBABILITY
            if kind == "number" and _width_is_open(raw, layout_field.bits, spare)
            else 1.0,
        ),
        kind=kind if kinds[kind] > 0.5 else "cannot tell",
        kind_probability=kinds[kind],
    )
    return _refined(signal, layout_field.readings)


def _known_signal(message: Message, known: Signal) -> LearnedSignal:
    raw = _column(message, known.start_bit, known.bits, is_big_endian=False)
    signal = _blank(message, known.start_bit, known.bits, raw).with_reasons(
        "SDO traffic in the log wrote or read this mapping", name=known.name, boundaries_probability=1.0
    )
    if len(raw) == 0 or np.all(raw == raw[0]):
        return signal.with_reasons(_constant_reason(raw), kind="constant", kind_probability=1.0)
    weights = reading_weights(raw, known.bits, message.direction)
    of_profile = profile_reading(known.name, known.bits)
    if known.is_float:
        weights = {("float", True): 0.0}
    elif of_profile is not None:
        weights = {of_profile: 0.0}
    total = log2_sum(weights.values())
    readings = {reading: 2.0 ** (weight - total) for reading, weight in weights.items()}
    kinds = _kinds(readings)
    kind = max(kinds, key=lambda name: kinds[name])
    refined = _refined(signal.with_reasons(kind=kind, kind_probability=kinds[kind]), readings)
    is_described = " " in known.name  # otherwise no object dictionary gave its type
    if of_profile is None:
        return replace(refined, signed=known.signed) if is_described else refined
    return replace(refined, kind=kind, signed=of_profile[1])


def _kinds(readings: Mapping[Reading, float]) -> dict[Kind, float]:
    """Return the probability of each kind, summed over its signs."""
    kinds: dict[Kind, float] = {}
    for (kind, _), share in readings.items():
        kinds[kind] = kinds.get(kind, 0.0) + share
    return kinds


def _blank(message: Message, start: int, bits: int, raw: NDArray[np.uint64]) -> LearnedSignal:
    return LearnedSignal(
        message.can_id, message.is_extended, message.node, start, bits, message.data.shape[1],
        is_big_endian=False, boundaries_probability=1.0, kind="cannot tell", kind_probability=0.0,
        signed=None, counter_range=0, name="", time=message.time, raw=raw,
    )  # fmt: skip


def _constant_reason(raw: NDArray[np.uint64]) -> str:
    value = int(raw[0]) if len(raw) else 0
    return f"it was {value:X}h in all {len(raw)} frames, so that its fields and its kind are not identified"


def _layout_reasons(layout_field: Field, kinds: Mapping[Kind, float], order: float) -> list[str]:
    last = layout_field.start + layout_field.bits - 1
    probability = f"P = {layout_field.probability:.3f}"
    reasons = [
        f"bits {layout_field.start} to {last} have the shortest description as one field, {probability}"
    ]
    if layout_field.bits > 8:
        name = "big-endian" if layout_field.is_big_endian else "little-endian"
        reasons.append(f"{name}: P = {order:.3f}")
    shares = ", ".join(
        f"{kind} {share:.3f}" for kind, share in sorted(kinds.items(), key=lambda item: -item[1])[:3]
    )
    reasons.append(f"as {shares}")
    return reasons


def _refined(signal: LearnedSignal, readings: Mapping[Reading, float]) -> LearnedSignal:
    """Return a number as a frame counter, as a time, or with its sign and range; other kinds as they are."""
    if signal.kind != "number":
        return signal
    code = number_code(signal.raw, signal.bits)
    is_range_sure = code.counter_range_odds > math.log2(1.0 / (1.0 - SURE_PROBABILITY))
    signal = replace(signal, counter_range=code.counter_range if is_range_sure else 0)
    steady = _counter_or_time(signal)
    if steady is not None:
        return steady
    signs = {signed: share for (kind, signed), share in readings.items() if kind == "number"}
    total = sum(signs.values()) or 1.0
    signed = max(signs, key=lambda sign: signs[sign]) if signs else None
    share = signs.get(signed, 0.0) / total
    if signal.counter_range:
        return signal.with_reasons(f"it starts again after {signal.counter_range} counts", signed=False)
    if share < SURE_PROBABILITY:
        return signal.with_reasons(
            "its sign is not identified: it crosses neither 0 nor the middle of its range"
        )
    highest_bits = signal.raw >> np.uint64(signal.bits - 1)
    if highest_bits.min() == highest_bits.max():
        reason = f"as {'signed' if signed else 'unsigned'} number {share:.3f}"
    else:
        reason = f"it crosses {'0' if signed else 'the middle of its range'} without a jump"
    return signal.with_reasons(reason, signed=signed)


def _counter_or_time(signal: LearnedSignal) -> LearnedSignal | None:
    """Return a signal as a counter of frames or a time; None if it is neither."""
    value = signal.unwrapped()
    step = np.diff(value)
    if len(step) < 8 or np.median(step) <= 0:
        return None
    median_step = float(np.median(step))
    same = float(np.mean(step == median_step))
    elapsed = signal.time - signal.time[0]
    interval = np.diff(signal.time)
    median_interval = float(np.median(interval))  # the median, because lost frames make long intervals
    is_regular = bool(np.median(np.abs(interval - median_interval)) < 0.01 * median_interval)
    slope, offset = np.polyfit(elapsed, value, 1)
    residual = float(np.std(value - slope * elapsed - offset))
    follows_time = (
        residual < 0.3 * median_step and not is_regular
    )  # at irregular intervals: a clock, no counter
    if same >= MIN_SAME_STEP_SHARE and median_step <= MAX_COUNTER_STEP and not follows_time:
        return signal.with_reasons(
            f"it grows by {median_step:.0f} from frame to frame, in {same:.1%} of them",
            kind="counter",
            signed=None,
        )
    jitter = max(float(np.std(interval)), 1e-4)
    is_clock = abs(slope) * jitter * 6 + 2.0 > residual
    is_clock &= residual < MAX_CLOCK_ERROR * abs(slope) * float(elapsed[-1])
    unit = (
        min((1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6), key=lambda rate: abs(np.log(slope / rate)))
        if slope > 0
        else 1.0
    )
    if is_clock and abs(slope / unit - 1.0) < 0.01:
        return signal.with_reasons(
            f"it grows in proportion to time, by {slope:.6g} per second", kind="time", signed=None
        )
    return None
