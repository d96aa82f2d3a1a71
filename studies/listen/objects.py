"""The values of objects over time: what a device of an EDS file shows while its robot drives."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from canopen.objectdictionary import ODVariable
from numpy.random import Generator
from numpy.typing import NDArray

from omnimate.vehicle.se2 import Array

Curve = Callable[[Array], Array]  # of times [s], (N,)
Raw = Callable[[Array], list[int]]  # of times [s], (N,): the raw numbers modulo 2^bits, (N,)

TYPES: dict[int | None, tuple[int, bool, bool]] = {  # CiA 301 data types: bits, signed, float
    1: (1, False, False), 2: (8, True, False), 3: (16, True, False), 4: (32, True, False),
    5: (8, False, False), 6: (16, False, False), 7: (32, False, False), 8: (32, True, True),
    0x10: (24, True, False), 0x15: (64, True, False), 0x16: (24, False, False), 0x1B: (64, False, False),
}  # fmt: skip
POSITIONS = {0x6004, 0x6020, 0x6063, 0x6064, 0x2020, 0x20A0, 0x2304, 0x2212}
POSITION_DEMANDS = {0x6062, 0x607A, 0x60FC, 0x60C1}
SPEEDS = {0x606C, 0x6069, 0x6030, 0x6044, 0x2028, 0x2029, 0x2069, 0x206C, 0x60FF, 0x606B, 0x6042, 0x6043}
TORQUES = {0x6077, 0x6074, 0x6071, 0x6078, 0x2027, 0x2031, 0x60FA}
ERRORS = {0x60F4, 0x20F4}
STATUS, CONTROL = (0x0240, 0x0231, 0x0233, 0x0237), (0x0000, 0x0006, 0x0007, 0x000F)  # CiA 402, until enabled


Session = float | None  # when the drives of a robot were enabled [s]; None before the log begins


@dataclass
class Values:
    """What an object shows at any time."""

    at: Raw  # its raw numbers
    kind: str  # what it is: number, bits, status word, control word, float, time, counter, bytes
    role: str = ""  # position, speed, torque, ... with the wheel or joint it is of, or ""
    sign: int = 1  # +1 or -1: whether forward counts up, of a position or speed
    scale: float = 0.0  # counts per radian, metre, or per second of these; 0 where it has none


class Shaft:
    """What a device measures: one wheel, joint or slider."""

    def __init__(self, random: Generator, time: Array, angle: Array, channel: str) -> None:
        self.random, self.time, self.angle, self.channel = random, time, angle, channel
        self.rate = np.gradient(angle, time)
        self.sign = int(random.choice([-1, 1]))
        unit = 2 * math.pi if channel != "link" else 0.1
        self.scale = math.exp(random.uniform(math.log(256), math.log(1 << 20))) / unit
        if random.random() < 0.5:
            self.scale = 2 ** round(math.log2(self.scale * unit)) / unit
        self.busy = float(np.max(np.abs(self.rate))) + 1e-9

    def curve(self, values: Array, factor: float, delay: float = 0.0) -> Curve:
        """Return some values over the shaft's time as a function of times, times a factor and delayed [s]."""
        return lambda times: factor * np.interp(times - delay, self.time, values)

    def position(self, bits: int, wrap: int | None = None, noise: float | None = None) -> Raw:
        random = self.random
        start = int(random.choice([0, int(random.integers(-3000, 3000)), int(random.integers(0, 2**31))]))
        ripple = random.choice([0.0, 0.0, 0.4, 1.5]) if noise is None else noise
        size = wrap or 2**bits

        def at(times: Array) -> list[int]:
            exact = self.sign * self.scale * np.interp(times, self.time, self.angle)
            counts = np.floor(exact + random.normal(0, ripple or 1e-9, len(times))).astype(np.int64) + start
            return [int(value) % size % 2**bits for value in counts]

        return at

    def speed(self, bits: int, signed: bool) -> tuple[Raw, float]:
        random = self.random
        span = 2 ** (bits - 1) - 1 if signed else 2**bits - 1
        unit = random.choice([self.scale, 60 / (2 * math.pi), 600 / (2 * math.pi), 1000.0, 30.0])
        unit = min(unit, 0.8 * span / self.busy)
        delay = random.choice([0.0, 0.004, 0.02])
        noise = random.choice([0.0, 0.003, 0.02]) * self.busy * unit + random.choice([0.0, 0.6])

        path = self.curve(self.rate, self.sign * unit, delay)
        return sampled(random, path, noise or 1e-9, bits, is_size=not signed), unit


def sampled(
    random: Generator,
    path: Curve,
    noise: float,
    bits: int,
    limits: tuple[float, float] | None = None,
    *,
    is_size: bool = False,
) -> Raw:
    """Return a function of times: raw numbers modulo 2^bits of a path with noise, rounded and within limits.

    With `is_size` a device shows the size alone, without a sign.
    """

    def at(times: Array) -> list[int]:
        value = np.rint(path(times) + random.normal(0, noise, len(times)))
        value = np.abs(value) if is_size else value
        return _pack(value if limits is None else np.clip(value, *limits), bits)

    return at


def values_of(random: Generator, entry: ODVariable, shaft: Shaft | None, session: Session) -> Values:
    """Return the values of an object of a device that measures a shaft, or nothing (None)."""
    index, subindex = entry.index, entry.subindex
    bits, signed, is_float = TYPES[entry.data_type]
    words = entry.name.lower()
    if index == 0x6041:
        return Values(_status(random, session), "status word")
    if index == 0x6040 and not subindex:  # in CiA 406 it is the acceleration of each sensor
        return Values(_control(random, session), "control word")
    if index == 0x6040 and shaft is not None:
        return Values(_acceleration(random, shaft, bits), "number", f"acceleration {shaft.channel}")
    if shaft is not None and bits >= 16 and not is_float:
        if index in POSITIONS or index in POSITION_DEMANDS:
            wrap = None
            if index == 0x6004 and random.random() < 0.4:
                wrap = int(random.choice([4096, 8192, 36000, 65536, 1 << 24, 1 << 25, 1 << 28]))
            return Values(
                shaft.position(bits, wrap, 0.0 if index in POSITION_DEMANDS else None),
                "number", f"position {shaft.channel}", shaft.sign, shaft.scale,
            )  # fmt: skip
        if index in SPEEDS:
            at, unit = shaft.speed(bits, signed)
            return Values(at, "number", f"speed {shaft.channel}", shaft.sign, unit)
        if index in TORQUES or "torque" in words or "current" in words:
            return Values(_torque(random, shaft, bits, signed), "number", f"torque {shaft.channel}")
        if index in ERRORS:
            return Values(_following(random, shaft, bits, signed), "number", f"error {shaft.channel}")
        if index == 0x2022:
            return Values(_hall(shaft), "bits")
    if is_float:
        return Values(_float(random), "float")
    if index == 0x2041:
        return Values(_stamp(random, bits), "time")
    if bits == 64:
        return Values(_held(random, bits), "bytes")
    if index in {0x6060, 0x6061}:
        return Values(_mode(random, session, bits), "bits")
    if (
        index in {0x60FD, 0x60FE, 0x6200, 0x2201, 0x2022, 0x6300, 0x6400, 0x2071, 0x2078, 0x22A0}
        or "digital" in words
    ):
        return Values(_flags(random, bits), "bits")
    if index in {0x603F, 0x1001, 0x6500, 0x6503, 0x6505, 0x2022, 0x60B9, 0x2082, 0x2085} or "status" in words:
        return Values((_held if random.random() < 0.6 else _flags)(random, bits), "bits")
    if index == 0x2021 and subindex < 4 and bits == 16:
        return Values(_line(random, bits), "number")
    if bits == 1:
        return Values(_flags(random, 1), "bits")
    if any(word in words for word in ("temp", "supply", "volt", "analog", "dc", "noise", "power")):
        return Values(_analog(random, bits, signed), "number")
    if entry.access_type in {"rw", "rww", "rwr", "wo"} and random.random() < 0.7:
        return Values(_held(random, bits), "bytes")
    choice = random.choice(["analog", "flags", "held", "counter"])
    if choice == "analog":
        return Values(_analog(random, bits, signed), "number")
    if choice == "flags" and bits <= 16:
        return Values(_flags(random, bits), "bits")
    if choice == "counter":
        return Values(_counter(random, bits), "counter")
    return Values(_held(random, bits), "bytes")


def _pack(values: Array | NDArray[np.int64], bits: int) -> list[int]:
    return [int(value) % 2**bits for value in values]


def _torque(random: Generator, shaft: Shaft, bits: int, signed: bool) -> Raw:
    size = random.choice([200.0, 600.0, 1500.0] if bits > 8 else [40.0])
    load = np.gradient(shaft.rate, shaft.time)
    load = load / (np.max(np.abs(load)) + 1e-9) * 0.7 + 0.3 * np.tanh(shaft.rate / shaft.busy * 5)
    noise = size * random.choice([0.004, 0.02, 0.06])
    return sampled(random, shaft.curve(load, size), noise, bits, is_size=not signed)


def _acceleration(random: Generator, shaft: Shaft, bits: int) -> Raw:
    rate = np.gradient(shaft.rate, shaft.time)
    unit = 0.8 * 2 ** (bits - 1) / (np.max(np.abs(rate)) + 1e-9) * random.choice([0.01, 0.1, 1.0])
    noise, span = random.uniform(0.5, 3.0), 2 ** (bits - 1)
    return sampled(random, shaft.curve(rate, shaft.sign * unit), noise, bits, (-span, span - 1))


def _following(random: Generator, shaft: Shaft, bits: int, signed: bool) -> Raw:
    lag = random.uniform(0.002, 0.02) * shaft.scale
    lag = min(lag, 0.6 * 2 ** (bits - 1) / shaft.busy)
    noise = random.uniform(0.5, 3.0)
    return sampled(random, shaft.curve(shaft.rate, lag), noise, bits, is_size=not signed)


def _hall(shaft: Shaft) -> Raw:
    def at(times: Array) -> list[int]:
        phase = np.floor(np.interp(times, shaft.time, shaft.angle) * 4 * 6 / (2 * np.pi)).astype(int) % 6
        return [(1, 3, 2, 6, 4, 5)[each] for each in phase]

    return at


def _status(random: Generator, session: Session) -> Raw:
    extra = int(random.choice([0x0000, 0x0400, 0x1000, 0x1400, 0x0080, 0x4000]))
    toggles = random.random() < 0.5
    flips = np.sort(random.uniform(0, 60, random.integers(4, 30)))
    words = [*STATUS[:3], STATUS[3] | extra]
    return lambda times: _state_words(times, session, words, 3, 0x0400 if toggles else 0, flips)


def _control(random: Generator, session: Session) -> Raw:
    halt = random.random() < 0.3
    flips = np.sort(random.uniform(0, 60, random.integers(2, 12)))
    return lambda times: _state_words(times, session, CONTROL, 3.3, 0x0100 if halt else 0, flips)


def _state_words(
    times: Array, session: Session, words: Sequence[int], enabled_step: float, toggled: int, flips: Array
) -> list[int]:
    """Return words of CiA 402, 0.15 s for each state, of which the last has bits toggled at the flips."""
    since = np.inf if session is None else (np.asarray(times) - session) / 0.15
    step = np.broadcast_to(np.clip(since + enabled_step, 0, 3).astype(int), len(times))
    flipped = (step == 3) & (np.searchsorted(flips, times) % 2 == 1)
    shown: list[int] = (np.array(words)[step] ^ np.where(flipped, toggled, 0)).tolist()
    return shown


def _mode(random: Generator, session: Session, bits: int) -> Raw:
    mode = int(random.choice([1, 3, 9, 8, 7, 6])) % 2**bits

    def at(times: Array) -> list[int]:
        if session is None:
            return [mode] * len(times)
        return [mode if time > session - 0.3 else 0 for time in times]

    return at


def _flags(random: Generator, bits: int) -> Raw:
    lines = random.choice(bits, size=min(bits, int(random.integers(1, 5))), replace=False)
    flips = {int(line): np.sort(random.uniform(0, 60, random.integers(1, 40))) for line in lines}
    base = int(random.choice([0, int(random.integers(0, 2 ** min(bits, 16)))]))

    def at(times: Array) -> list[int]:
        words = np.full(len(times), base, np.int64)
        for line, moments in flips.items():
            words ^= (np.searchsorted(moments, times) % 2).astype(np.int64) << line
        return _pack(words, bits)

    return at


def _held(random: Generator, bits: int) -> Raw:
    chosen = [int(random.integers(0, 2 ** min(bits, most))) for most in (15, 62)]
    value = int(random.choice([0, 0, 1, *chosen]))
    return lambda times: [value % 2**bits] * len(times)


def _counter(random: Generator, bits: int, most: int = 200) -> Raw:
    start = int(random.integers(0, most))
    return lambda times: [(start + n) % 2**bits for n in range(len(times))]


def _stamp(random: Generator, bits: int) -> Raw:
    start = int(random.integers(0, 2**31))
    unit = random.choice([1e6, 1e6, 1e3, 1e5])
    return lambda times: [(start + int(time * unit)) % 2**bits for time in times]


def _line(random: Generator, bits: int) -> Raw:
    grid = np.arange(0, 70, 0.05)
    path = np.cumsum(random.normal(0, 1, len(grid))) * 1.5
    path = 60 * np.tanh((path - np.convolve(path, np.ones(100) / 100, "same")) / 30)
    noise = random.choice([0.0, 0.3, 1.0])
    return sampled(random, lambda times: np.interp(times, grid, path), noise or 1e-9, bits)


def _slow(random: Generator, base: float, wander: float) -> Curve:
    grid = np.arange(0, 70, 0.5)
    path = base + wander * np.cumsum(random.normal(0, 0.2, len(grid)))
    return lambda times: np.interp(times, grid, path)


def _analog(random: Generator, bits: int, signed: bool) -> Raw:
    span = 2 ** (bits - 1) if signed else 2**bits
    base = random.choice([25, 60, 240, 480, 1200, 3000, 20000])
    base = min(base, span * 0.4)
    base = -base * 0.3 if signed and random.random() < 0.2 else base
    path = _slow(random, base, abs(base) * random.choice([0.002, 0.01, 0.05]) + 0.2)
    noise = random.choice([0.2, 0.5, 3.0, 12.0]) if abs(base) > 100 else random.choice([0.05, 0.3])
    return sampled(random, path, noise, bits, (-span if signed else 0, span - 1))


def _float(random: Generator) -> Raw:
    base = random.choice([24.5, 41.0, 0.3, -3.0, 0.0, 1200.0])
    path = _slow(random, base, 0.02 * abs(base) + 0.05)
    noise = random.choice([1e-3, 0.01, 0.1]) * (abs(base) + 0.1)
    grain = random.choice([0.0, 0.0, 0.0625, 0.1])

    def at(times: Array) -> list[int]:
        value = path(times) + random.normal(0, noise, len(times))
        if grain:
            value = np.rint(value / grain) * grain
        return [struct.unpack("<I", struct.pack("<f", each))[0] for each in value]

    return at
