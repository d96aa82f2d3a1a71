"""Messages of devices that know nothing of CANopen: packed bits, either byte order, counters, checksums."""

from __future__ import annotations

import numpy as np
from numpy.random import Generator

from studies.listen.devices import FieldTruth, Pdo
from studies.listen.objects import Raw, _counter, _flags, _slow, sampled

IDENTIFIERS = np.arange(0x101, 0x180)  # none of CANopen's services or PDOs


def foreign_messages(random: Generator) -> list[Pdo]:
    """Return some messages with all that they carry."""
    messages = []
    for can_id in random.choice(IDENTIFIERS, int(random.integers(1, 4)), replace=False).tolist():
        is_big = bool(random.random() < 0.5)
        message = Pdo(
            can_id, 0, 0, is_receive=False, cause="timer", every=float(random.choice([0.01, 0.02, 0.05, 0.1]))
        )
        bit, length = 0, 8 * int(random.choice([8, 8, 8, 6, 4]))
        while bit < length:
            kind = str(random.choice(["number", "number", "number", "counter", "flags", "gap", "checksum"]))
            bits = {
                "number": int(random.choice([8, 10, 12, 12, 14, 16, 16, 20])),
                "counter": int(random.choice([2, 4, 8])),
                "flags": int(random.integers(1, 5)),
                "gap": int(random.integers(1, 9)),
                "checksum": 8,
            }[kind]
            if bit + bits > length:
                break
            if kind != "gap":
                message.fields.append(_field(random, kind, bit, bits, is_big))
            bit += bits
        message.bytes = length // 8
        if message.fields:
            messages.append(message)
    return messages


def _field(random: Generator, kind: str, bit: int, bits: int, is_big: bool) -> FieldTruth:
    signed = kind == "number" and bool(random.random() < 0.4)
    values = {
        "number": lambda: _number(random, bits, signed),
        "counter": lambda: _counter(random, bits, 2**bits),
        "flags": lambda: _flags(random, bits),
        "checksum": lambda: _noise(random, bits),
    }[kind]()
    name = {"flags": "bits", "checksum": "noise"}.get(kind, kind)
    return FieldTruth(bit, bits, signed, name, "", 1, 0.0, (0, 0), values, is_big_endian=is_big)


def _number(random: Generator, bits: int, signed: bool) -> Raw:
    span = 2 ** (bits - 1) if signed else 2**bits
    middle = 0.0 if signed else span * random.uniform(0.2, 0.7)
    path = _slow(random, middle, span * random.uniform(0.02, 0.08))
    swing, beat = span * random.uniform(0.02, 0.2), random.uniform(0.3, 3.0)
    noise = random.choice([0.2, 1.0, span * 0.002])
    limits = -span if signed else 0, span - 1
    return sampled(random, lambda times: path(times) + swing * np.sin(beat * times), noise, bits, limits)


def _noise(random: Generator, bits: int) -> Raw:
    return lambda times: random.integers(0, 2**bits, len(times)).tolist()
