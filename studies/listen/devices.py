"""The devices of EDS files and the PDOs that they may send."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from canopen.objectdictionary import ODVariable
from numpy.random import Generator

from omnimate.driver.canopen.eds import load_eds
from omnimate.files.logs.frames import Frames
from studies.listen.objects import TYPES, Raw, Session, Shaft, values_of

ROOT = Path(__file__).resolve().parents[2]
OURS = ROOT / "vcan_sim" / "eds"
FOREIGN = ROOT.parent / "shared" / "data" / "eds"


def eds_files(folders: Sequence[Path] = (FOREIGN, OURS)) -> dict[str, Path]:
    """Return all EDS and DCF files by name: those of the data and those of the simulated vehicle."""
    return {path.stem: path for folder in folders for path in sorted(folder.glob("*.[ed][dc][sf]"))}


@dataclass
class Entry:
    """An object that may be mapped."""

    index: int
    subindex: int
    name: str
    type: int
    access: str

    @property
    def bits(self) -> int:
        return TYPES[self.type][0]


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
        return self.bytes or (sum(each.bits for each in self.fields) + 7) // 8

    @property
    def is_big_endian(self) -> bool:
        return bool(self.fields) and self.fields[0].is_big_endian


@dataclass
class Bus:
    """A log and its truth."""

    frames: Frames  # the log
    pdos: dict[int, Pdo]  # the PDOs by COB-ID
    boots: bool = False  # whether the boot-up and the SDO traffic are in the log


Plan = tuple[bool, int, list[Entry]]  # of a PDO: whether the node receives it, its number, what it carries


@cache
def described(path: Path) -> tuple[dict[tuple[int, int], Entry], list[Plan]]:
    """Return the mappable objects of an EDS file, and its default mappings by base index and number."""
    dictionary = load_eds(path, 1).dictionary
    entries: dict[tuple[int, int], Entry] = {}
    every: dict[tuple[int, int], Entry] = {}
    for index, item in dictionary.items():
        variables = [item] if isinstance(item, ODVariable) else list(item.values())
        for variable in variables:
            if variable.data_type not in TYPES or (
                not isinstance(item, ODVariable) and variable.subindex == 0
            ):
                continue
            entry = Entry(index, variable.subindex, variable.name, variable.data_type, variable.access_type)
            every[index, variable.subindex] = entry
            if variable.pdo_mappable and index >= 0x2000:
                entries[index, variable.subindex] = entry
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
                if mapped is None or mapped.bits != value & 0xFF:
                    break
                carried.append(mapped)
            if carried:
                defaults.append((receives, number, carried))
    return entries, defaults


def pdos_of(random: Generator, path: Path, node: int, shafts: Sequence[Shaft], session: Session) -> list[Pdo]:
    """Return the PDOs of a device, by its EDS defaults or others that its objects allow."""
    entries, defaults = described(path)
    own = random.random() < 0.5
    plans: list[Plan] = []
    for receives, number, carried in defaults:
        if number < 4 and own and random.random() < 0.85:
            plans.append((receives, number, carried))
    taken = {(receives, number) for receives, number, _ in plans}
    sendable = [entry for entry in entries.values() if entry.access != "wo" and not _is_control(entry)]
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
            values = values_of(
                random, entry.index, entry.subindex, entry.name, entry.type, shaft, session, entry.access
            )
            bits, signed, is_float = TYPES[entry.type]
            pdo.fields.append(
                FieldTruth(bit, bits, signed or is_float, values.kind, values.role, values.sign, values.scale,
                           (entry.index, entry.subindex), values.at)
            )  # fmt: skip
            bit += bits
        if pdo.fields:
            pdos.append(pdo)
    return pdos


def _is_control(entry: Entry) -> bool:
    """Return whether an object is the control word of CiA 402; in CiA 406, 6040h is an array."""
    return entry.index == 0x6040 and not entry.subindex


def _shaft_of(entry: Entry, shafts: Sequence[Shaft]) -> Shaft | None:
    if not shafts:
        return None
    if entry.index in {0x6020, 0x6030} and len(shafts) > 1:
        return shafts[(entry.subindex - 1) % len(shafts)]
    return shafts[0]


def _some(random: Generator, entries: Sequence[Entry], shafts: Sequence[Shaft]) -> list[Entry]:
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
    carried: list[Entry] = []
    drawn = random.choice(
        len(entries), size=len(entries), replace=False, p=[w / sum(weights) for w in weights]
    )
    for number in drawn:
        entry = entries[int(number)]
        if entry.index == 0x6020 and entry.subindex > max(len(shafts), 1):
            continue
        if entry.bits <= room and len(carried) < 5:
            carried.append(entry)
            room -= entry.bits
        if random.random() < 0.2:
            break
    order = random.permutation(len(carried)) if random.random() < 0.6 else range(len(carried))
    return [carried[int(number)] for number in order]
