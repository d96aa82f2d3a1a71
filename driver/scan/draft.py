"""Drafts a `vehicle.toml` from a scan; comments say how to find the keys that a scan cannot know."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.driver.canopen.pdo_mapping import AXIS, placed
from omnimate.driver.canopen.pdo_parameters import TPDO
from omnimate.driver.scan.node import LINEAR, LINEAR_SENSORS, SINGLE_TURN
from omnimate.files.logs.seen_mapping import FIRST_RPDO, FIRST_TPDO, PREDEFINED, predefined_cob_id
from omnimate.vehicle.drafting import bus_lines, geometry_lines, known_line, unknown_line

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from omnimate.driver.canopen.pdo_parameters import PdoSetting
    from omnimate.driver.scan.node import NodeReading
    from omnimate.driver.scan.scan import Scan

POSITION, SENSORS, ACTUAL, INTERNAL, TARGET = 0x6004, 0x6020, 0x6064, 0x6063, 0x60FF
SIGNED = frozenset({SENSORS, ACTUAL, INTERNAL})  # data types of CiA 406 and 402; 6004h is unsigned
AXES = 8  # of one CiA 402 device
SCALES = 1 << 2  # bit of 6000h: the scaling of 6001h and 6002h is in use
MAX_WHEELS_PER_TRUCK = 2

HEAD = """\
# Drafted by `omnimate scan`. Keys that the bus does not report are commented out: follow the comment after
# them, and remove the #. `omnimate record --vehicle` names the first key that is missing.
# To see a counter:  omnimate sdo read {example} --bus {url} --node {node}"""


@dataclass(frozen=True, slots=True)
class Position:
    """A position object of a node, and its field in a PDO."""

    node: NodeReading
    index: int
    subindex: int
    cob_id: int  # COB-ID of the PDO that carries it, or that shall carry it
    start_bit: int  # first bit in the PDO
    bits: int  # width
    is_mapped: bool  # whether the PDO carries it already

    @property
    def is_of_drive(self) -> bool:
        """Whether it is an object of CiA 402."""
        return self.index not in {POSITION, SENSORS}

    @property
    def is_linear(self) -> bool:
        """Whether a linear encoder measures it."""
        return self.node.encoder_type in {LINEAR, LINEAR_SENSORS}

    @property
    def is_single_turn(self) -> bool:
        """Whether a single-turn encoder measures it, as at a joint."""
        return self.node.encoder_type == SINGLE_TURN

    @property
    def counts_up(self) -> str:
        """What counts up, by the conventions of `vehicle.toml`."""
        if self.is_linear:
            return "a longer linkage"
        return "a truck that turns left" if self.is_single_turn else "a wheel that rolls forward"

    @property
    def zero(self) -> str:
        """Where `zero` is; empty for a wheel."""
        if self.is_linear:
            return "at linkage.length"
        return "where truck and linkage are in line" if self.is_single_turn else ""

    @property
    def in_words(self) -> str:
        """The object as `vehicle.toml` names it."""
        return f"{self.index:04X}h" + (f":{self.subindex}" if self.subindex else "")


def draft_vehicle(scan: Scan, url: str, bitrate: int | None, eds: Mapping[int, str]) -> str:
    """Return the text of a `vehicle.toml` with the nodes that a scan has read.

    Args:
        scan: Nodes and traffic of the bus.
        url: URL of the bus, for the commands in the comments.
        bitrate: Bit rate of the bus [bit/s]; None where it is not known.
        eds: Paths of EDS and DCF files by node id, as they are seen from the file.
    """
    positions = [position for node in scan.nodes for position in positions_of(node)]
    # what can turn a wheel by target velocity
    drives = [node for node in scan.nodes if node.value(TARGET) is not None or _target_pdo(node) is not None]
    encoders = [position for position in positions if not position.is_of_drive] or positions
    wheels = sum(not position.is_linear for position in encoders)
    has_two = wheels > MAX_WHEELS_PER_TRUCK or len(drives) > MAX_WHEELS_PER_TRUCK
    example = encoders[0] if encoders else None
    head = HEAD.format(
        example="6004h" if example is None else example.in_words,
        url=url,
        node=1 if example is None else example.node.node,
    )
    lines = [
        head,
        "",
        'name = "robot"',
        *geometry_lines(has_two=has_two),
        *bus_lines(bitrate, scan.traffic.sync_period),
    ]
    for position in encoders:
        lines += _encoder(position, encoders, eds)
    for position in positions:
        if position not in encoders:
            lines += ["", f"# node {position.node.node} measures, too: {position.in_words}, profile cia402"]
    for node in drives:
        lines += _drive(node, eds)
    if not encoders:
        lines += ["", "# no encoder was found: switch all devices on, and scan again with a longer --wait"]
    return "\n".join([*lines, ""])


def positions_of(node: NodeReading) -> list[Position]:
    """Return the positions that a node has: those in its TPDOs, else that of its profile.

    Of several TPDOs with the same position, one that is on and answers SYNC comes first.
    """
    first: dict[tuple[int, int], Position] = {}
    for setting in sorted(node.tpdos, key=_preference):
        for bit, entry in placed(setting.entries):
            if _is_position(entry.index):
                where = (_cob_id(setting, node.node), bit, entry.bits)
                is_mapped = not setting.is_extended
                position = Position(node, entry.index, entry.subindex, *where, is_mapped=is_mapped)
                first.setdefault((entry.index, entry.subindex), position)
    mapped = sorted(first.values(), key=lambda position: (position.index, position.subindex))
    if mapped:
        has_actual = any((position.index - ACTUAL) % AXIS == 0 for position in mapped)
        return [p for p in mapped if not (has_actual and (p.index - INTERNAL) % AXIS == 0)]
    default = {406: POSITION, 402: ACTUAL}.get(node.profile or 0)
    if default is None:
        return []
    bases = [setting.base & 0xFF for setting in node.tpdos]
    number = 1 if 1 in bases else 0
    cob_id = predefined_cob_id(FIRST_TPDO, number, node.node)
    return [Position(node, default, 0, cob_id, 0, 32, is_mapped=False)]


def _cob_id(setting: PdoSetting, node: int) -> int:
    """Return the COB-ID of a PDO, or where it has 29 bits the predefined one, which the driver will set."""
    if not setting.is_extended:
        return setting.cob_id
    number = setting.base & 0xFF
    first = FIRST_TPDO if setting.base >= TPDO else FIRST_RPDO
    return predefined_cob_id(first, number if number < PREDEFINED else 0, node)


def _preference(setting: PdoSetting) -> tuple[bool, bool, int]:
    return (not setting.is_valid, not 1 <= setting.transmission <= 240, setting.base)


def _is_position(index: int) -> bool:
    axes = range(0, AXES * AXIS, AXIS)
    return index in {POSITION, SENSORS} or any(index - axis in {ACTUAL, INTERNAL} for axis in axes)


def _target_pdo(node: NodeReading) -> PdoSetting | None:
    """Return the RPDO that carries the target velocity, None where none does."""
    carrying = [setting for setting in node.rpdos if any(entry.index == TARGET for entry in setting.entries)]
    return min(carrying, key=_preference, default=None)


def _encoder(position: Position, all_positions: Sequence[Position], eds: Mapping[int, str]) -> Iterator[str]:
    node = position.node
    yield from ("", "[[encoder]]")
    yield _channel(position, all_positions)
    yield known_line("node", str(node.node), _described(node))
    how = "carries it already" if position.is_mapped else "the driver will map it"
    yield known_line("cob_id", f"0x{position.cob_id:03X}", how)
    yield known_line("start_bit", str(position.start_bit))
    yield known_line("bits", str(position.bits))
    yield known_line("signed", "true" if position.index in SIGNED or position.is_of_drive else "false")
    yield unknown_line("sign", "1", f"1 or -1, so that {position.counts_up} counts up")
    yield _scale(position)
    if position.zero:
        yield unknown_line("zero", "0", f"the count {position.zero}")
    if position.is_of_drive:
        yield known_line("profile", '"cia402"')
    if position.index not in {POSITION, ACTUAL}:
        yield known_line("object", f'"{position.in_words}"')
    for key in ("vendor", "product", "serial"):
        value = getattr(node, key)
        if value:
            yield known_line(key, f"0x{value:X}")
    if node.node in eds:
        yield known_line("eds", json.dumps(eds[node.node]))


def _channel(position: Position, all_positions: Sequence[Position]) -> str:
    linear = [other for other in all_positions if other.is_linear]
    if linear == [position]:
        return known_line("channel", '"link"', "the only linear encoder")
    if position.is_linear:
        return unknown_line("channel", '"link"', "move the linkage, and see which one counts")
    if position.is_single_turn:
        return unknown_line("channel", '"joint_a"', "or joint_b: turn the joint, and see which one counts")
    wheels = "a.left, a.right, b.left or b.right"
    return unknown_line("channel", '"a.left"', f"{wheels}: turn the wheel, and see which one counts")


def _scale(position: Position) -> str:
    node = position.node
    if position.is_linear:
        step = node.value(0x6005, 1) or node.value(0x6501)  # [nm], CiA 406
        if step:
            return known_line("counts_per_metre", f"{1e9 / step:.10g}", f"a step is {step} nm")
        return unknown_line("counts_per_metre", "10000", "see its data sheet")
    if position.is_of_drive:
        return _drive_scale(node)
    scaled = (node.value(0x6000) or 0) & SCALES
    counts = (node.value(0x6001) if scaled else None) or node.value(0x6501) or node.value(0x6001)
    if counts:
        return known_line("counts_per_turn", str(counts), "of the encoder: times the gear, if there is one")
    return unknown_line("counts_per_turn", "4096", "of the wheel: resolution of the encoder times the gear")


def _drive_scale(node: NodeReading) -> str:
    """Return the counts per turn of a drive's shaft, 608Fh and 6091h of CiA 402."""
    counts, turns = node.value(0x608F, 1), node.value(0x608F, 2) or 1
    motor, shaft = node.value(0x6091, 1) or 1, node.value(0x6091, 2) or 1
    if counts:
        comment = "608Fh and its gear 6091h" if motor != shaft else "608Fh; times the gear, if there is one"
        return known_line("counts_per_turn", f"{counts / turns * motor / shaft:.10g}", comment)
    return unknown_line("counts_per_turn", "4096", "of the wheel: resolution of the encoder times the gear")


def _drive(node: NodeReading, eds: Mapping[int, str]) -> Iterator[str]:
    setting = _target_pdo(node)
    yield from ("", "[[drive]]")
    yield unknown_line(
        "wheel", '"a.left"', "a.left, a.right, b.left or b.right: the wheel that this motor turns"
    )
    yield known_line("node", str(node.node), _described(node))
    cob_id, start, how = predefined_cob_id(FIRST_RPDO, 0, node.node), 0, "the driver will map it"
    if setting is not None:
        start = next(bit for bit, entry in placed(setting.entries) if entry.index == TARGET)
        cob_id = _cob_id(setting, node.node)
        how = how if setting.is_extended else "carries 60FFh"
    yield known_line("cob_id", f"0x{cob_id:03X}", how)
    if start:
        yield known_line("start_bit", str(start), "of 60FFh")
    yield unknown_line("sign", "1", "1 or -1, so that a positive speed rolls forward")
    yield _drive_scale(node)
    if node.node in eds:
        yield known_line("eds", json.dumps(eds[node.node]))


def _described(node: NodeReading) -> str:
    return " ".join(word for word in (node.type_in_words, node.name) if word)
