"""The devices of EDS files and the PDOs that they may send."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np
from canopen.objectdictionary import ODVariable
from numpy.random import Generator

from omnimate.driver.canopen.eds import load_eds
from omnimate.files.logs.frames import Frames
from studies.listen.objects import TYPES, Raw, Session, Shaft, _counter, _flags, _slow, sampled, values_of

ROOT = Path(__file__).resolve().parents[2]
OURS = ROOT / "vcan_sim" / "eds"
FOREIGN = ROOT.parent / "shared" / "data" / "eds"


def eds_files(folders: Sequence[Path] = (FOREIGN, OURS)) -> dict[str, Path]:
    """Return all EDS and DCF files by name: those of the data and those of the simulated vehicle."""
    return {path.stem: path for folder in folders for path in sorted(folder.glob("*.[ed][dc][sf]"))}


@dataclass
class FieldTruth:
    """What a field of a PDO is."""

    start: int  # first bit, little-endian
    bits: int  # width
    signed: bool  # whether the device writes two's complement (or a float)
    kind: str  # kind of `objects.Values`
    role: str  # what it is of
    sign: int  # direction of a position or speed
    scale: float  # counts per radian or metre, or per second
    object: tuple[int, int]  # index and sub-index
    values: Raw | None = None  # None of a recorded log
    is_big_endian: bool = False  # whether its bits are those of the number of the bytes in the other order


@dataclass
class Pdo:
    """A PDO: what it carries and when it is sent."""

    cob_id: int  # COB-ID
    node: int  # node whose parameters say so
    number: int  # number of the PDO, from 0
    is_receive: bool  # whether the node receives it
    fields: list[FieldTruth] = field(default_factory=list)  # what it carries
    cause: str = "sync"  # `sync`, `timer` or `change`
    every: float = 1  # number of SYNCs, or seconds
    bytes: int = 0  # length; 0 for as long as its fields

    @property
    def length(self) -> int:
        return self.bytes or (sum(field.bits for field in self.fields) + 7) // 8

    @property
    def is_big_endian(self) -> bool:
        return bool(self.fields) and self.fields[0].is_big_endian


@dataclass
class Bus:
    frames: Frames  # the log
    pdos: dict[int, Pdo]  # the PDOs by COB-ID
    boots: bool = False  # whether the boot-up and the SDO traffic are in the log


# Of a PDO: whether the node receives it, its number, what it carries.
Plan = tuple[bool, int, list[ODVariable]]


@cache
def described(path: Path) -> tuple[dict[tuple[int, int], ODVariable], list[Plan]]:
    """Return the mappable objects of an EDS file, and its default mappings by base index and number."""
    dictionary = load_eds(path, 1).dictionary
    entries: dict[tuple[int, int], ODVariable] = {}
    every: dict[tuple[int, int], ODVariable] = {}
    for index, item in dictionary.items():
        variables = [item] if isinstance(item, ODVariable) else list(item.values())
        for variable in variables:
            if variable.data_type not in TYPES or (
                not isinstance(item, ODVariable) and variable.subindex == 0
            ):
                continue
            every[index, variable.subindex] = variable
            if variable.pdo_mappable and index >= 0x2000:
                entries[index, variable.subindex] = variable
    if not entries:  # the profile's file marks none, not even 6004h
        wanted = {0x6004, 0x6020, 0x6030, 0x6040, 0x6300, 0x6400, 0x6500, 0x6503, 0x6505}
        entries = {key: entry for key, entry in every.items() if key[0] in wanted}
    defaults = []
    for base, receives in ((0x1600, True), (0x1A00, False)):
        for number in range(8):
            if base + number not in dictionary:
                continue
            mapping = dictionary[base + number]
            carried = []
            for subindex in range(1, 9):
                variable = mapping.get(subindex) if not isinstance(mapping, ODVariable) else None
                value = None if variable is None else variable.value or variable.default
                if not isinstance(value, int) or not value:
                    break
                mapped = every.get((value >> 16, value >> 8 & 0xFF))
                if mapped is None or TYPES[mapped.data_type][0] != value & 0xFF:
                    break
                carried.append(mapped)
            if carried:
                defaults.append((receives, number, carried))
    return entries, defaults


def pdos_of(random: Generator, path: Path, node: int, shafts: Sequence[Shaft], session: Session) -> list[Pdo]:
    """Return the PDOs of a device, by its EDS defaults or others that its objects allow."""
    entries, defaults = described(path)
    has_own = random.random() < 0.5
    plans: list[Plan] = []
    for receives, number, carried in defaults:
        if number < 4 and has_own and random.random() < 0.85:
            plans.append((receives, number, carried))
    taken = {(receives, number) for receives, number, _ in plans}
    sendable = [entry for entry in entries.values() if entry.access_type != "wo" and not _is_control(entry)]
    if sendable:
        free = [number for number in range(int(random.integers(1, 4))) if (False, number) not in taken]
        plans += [(False, number, _some(random, sendable, shafts)) for number in free]
    targets = {0x60FF, 0x607A, 0x6060, 0x6071, 0x6042}
    commands = [entry for entry in entries.values() if _is_control(entry) or entry.index in targets]
    if commands and not any(receives for receives, *_ in plans) and random.random() < 0.7:
        head = [entry for entry in commands if _is_control(entry)] if random.random() < 0.5 else []
        rest = [entry for entry in commands if not _is_control(entry)]
        pick = [rest[int(random.integers(len(rest)))]] if rest else []
        plans.append((True, int(random.integers(0, 4)), head + pick or commands[:1]))
    pdos = []
    for receives, number, carried in plans:
        pdo = Pdo((0x200 if receives else 0x180) + 0x100 * number + node, node, number, receives)
        bit = 0
        for entry in carried:
            shaft = _shaft_of(entry, shafts)
            values = values_of(random, entry, shaft, session)
            bits, signed, is_float = TYPES[entry.data_type]
            pdo.fields.append(
                FieldTruth(bit, bits, signed or is_float, values.kind, values.role, values.sign, values.scale,
                           (entry.index, entry.subindex), values.at)
            )  # fmt: skip
            bit += bits
        if pdo.fields:
            pdos.append(pdo)
    return pdos


def _is_control(entry: ODVariable) -> bool:
    """Return whether an object is the control word of CiA 402; in CiA 406, 6040h is an array."""
    return entry.index == 0x6040 and not entry.subindex


def _shaft_of(entry: ODVariable, shafts: Sequence[Shaft]) -> Shaft | None:
    if not shafts:
        return None
    if entry.index in {0x6020, 0x6030} and len(shafts) > 1:
        return shafts[(entry.subindex - 1) % len(shafts)]
    return shafts[0]


def _some(random: Generator, entries: Sequence[ODVariable], shafts: Sequence[Shaft]) -> list[ODVariable]:
    """Return objects at random that fit a PDO; what a robot is for comes more often."""
    wanted = {
        0x6064: 6,
        0x6004: 8,
        0x6063: 3,
        0x606C: 4,
        0x6041: 5,
        0x6020: 5,
        0x6030: 3,
        0x6077: 2,
        0x6078: 2,
    }
    weights = [wanted.get(entry.index, 0.5) for entry in entries]
    room = 8 * int(random.choice([8, 8, 8, 6, 4]))
    carried: list[ODVariable] = []
    drawn = random.choice(
        len(entries), size=len(entries), replace=False, p=[w / sum(weights) for w in weights]
    )
    for number in drawn:
        entry = entries[int(number)]
        if entry.index == 0x6020 and entry.subindex > max(len(shafts), 1):
            continue
        if TYPES[entry.data_type][0] <= room and len(carried) < 5:
            carried.append(entry)
            room -= TYPES[entry.data_type][0]
        if random.random() < 0.2:
            break
    order = random.permutation(len(carried)) if random.random() < 0.6 else range(len(carried))
    return [carried[int(number)] for number in order]


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
