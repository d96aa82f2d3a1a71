"""Reads the identity, PDOs and profile objects of one node by SDO."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from omnimate.driver.canopen.node_setup import MIN_DUPLICATES
from omnimate.driver.canopen.object_values import decode
from omnimate.driver.canopen.pdo_parameters import RPDO, TPDO, PdoSetting, read_pdos
from omnimate.driver.errors import NodeError, SdoRefused, SdoSilent, TwoDevices

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from omnimate.driver.canopen.sdo import Sdo

PROFILES = {
    0: "no profile",
    401: "I/O module",
    402: "drive",
    404: "measuring device",
    405: "controller",
    406: "encoder",
    408: "hydraulic drive",
    410: "inclinometer",
    418: "battery",
    419: "charger",
    447: "special-purpose car add-on",
    454: "energy management",
}
# Encoder types in the upper half of 1000h, CiA 406; 8 and Ah from TR-Electronic's manual of the LA-46-K.
SINGLE_TURN, MULTI_TURN, LINEAR, LINEAR_SENSORS = 1, 2, 8, 10
ENCODER_TYPES = {
    SINGLE_TURN: "single-turn encoder",
    MULTI_TURN: "multi-turn encoder",
    LINEAR: "linear encoder",
    LINEAR_SENSORS: "linear encoder",
}
ENCODER_OBJECTS = ((0x6000, 0), (0x6001, 0), (0x6002, 0), (0x6005, 1), (0x6501, 0), (0x6502, 0))
DRIVE_OBJECTS = (
    *((0x6041, 0), (0x6502, 0), (0x608F, 1), (0x608F, 2), (0x6091, 1), (0x6091, 2)),
    *((0x6063, 0), (0x6064, 0), (0x60FF, 0)),
)
OBJECTS = {406: ENCODER_OBJECTS, 402: DRIVE_OBJECTS}
IDENTITY = 0x1018
MAX_TEXT = 60  # characters of a name or version that are returned


class ServerBusyError(NodeError):
    """Another master has begun an SDO dialogue with a node, which is therefore not read further."""

    def __init__(self, node: int) -> None:
        super().__init__(node, "another master talks to it by SDO; it is left alone", "scan again later")


@dataclass(frozen=True, slots=True)
class NodeReading:
    """Objects that were read from a node; None and empty where it has no such object."""

    node: int  # CANopen node id
    device_type: int | None = None  # 1000h
    vendor: int | None = None  # 1018h:1
    product: int | None = None  # 1018h:2
    revision: int | None = None  # 1018h:3
    serial: int | None = None  # 1018h:4
    name: str = ""  # 1008h
    hardware: str = ""  # 1009h, hardware version
    software: str = ""  # 100Ah, software version
    heartbeat: float = 0.0  # 1017h, time between two heartbeats [s]; 0 for none
    guarding: float = 0.0  # 100Ch times 100Dh, time in which it must be guarded [s]; 0 for none
    tpdos: tuple[PdoSetting, ...] = ()  # TPDOs among the first four
    rpdos: tuple[PdoSetting, ...] = ()  # RPDOs among the first four
    # objects of its profile by index and sub-index
    objects: Mapping[tuple[int, int], int] = field(default_factory=dict)
    remark: str = ""  # what is wrong with it, or why not all of it was read; empty where nothing is

    @property
    def profile(self) -> int | None:
        """Number of the device profile, such as 406; None where 1000h was not read."""
        return None if self.device_type is None else self.device_type & 0xFFFF

    @property
    def encoder_type(self) -> int | None:
        """Encoder type of a CiA 406 encoder."""
        return None if self.device_type is None or self.profile != 406 else self.device_type >> 16

    @property
    def type_in_words(self) -> str:
        """Profile and kind of device, such as `406 multi-turn encoder`; empty where it is not known."""
        if self.profile is None:
            return ""
        kind = PROFILES.get(self.profile, "")
        if self.encoder_type is not None:
            kind = ENCODER_TYPES.get(self.encoder_type, kind)
        return f"{self.profile} {kind}".removeprefix("0 ").strip()

    def value(self, index: int, subindex: int = 0) -> int | None:
        """Return an object of its profile, None where it has none."""
        return self.objects.get((index, subindex))


def read_node(sdo: Sdo) -> NodeReading:
    """Return the objects of a node; nothing is written.

    Objects that were read before it fell silent, or before another master addressed it, are returned. Raises
    BusLost.
    """
    sdo.reset_duplicate_answers()
    fields: dict[str, Any] = {"node": sdo.node}
    try:
        for name, value in _parts(sdo):
            fields[name] = value  # noqa: PERF403  # what was read before an error counts
    except (SdoSilent, ServerBusyError) as error:
        fields["remark"] = error.problem
    if sdo.duplicate_answers >= MIN_DUPLICATES:
        fields["remark"] = TwoDevices(sdo.node).problem
    return NodeReading(**fields)


def _parts(sdo: Sdo) -> Iterator[tuple[str, Any]]:
    """Yield the fields of a reading, by name, as they are read."""
    device_type = sdo.find(0x1000)
    yield "device_type", device_type
    for subindex, name in enumerate(("vendor", "product", "revision", "serial"), start=1):
        yield name, sdo.find(IDENTITY, subindex)
    yield "heartbeat", (sdo.find(0x1017) or 0) * 1e-3
    yield "guarding", (sdo.find(0x100C) or 0) * (sdo.find(0x100D) or 0) * 1e-3
    yield "tpdos", read_pdos(sdo, TPDO)
    yield "rpdos", read_pdos(sdo, RPDO)
    wanted = OBJECTS.get((device_type or 0) & 0xFFFF, ())
    values = {place: sdo.find(*place) for place in wanted}
    yield "objects", {place: value for place, value in values.items() if value is not None}
    for index, name in ((0x1008, "name"), (0x1009, "hardware"), (0x100A, "software")):
        yield name, _text(sdo, index)


def _text(sdo: Sdo, index: int) -> str:
    """Return a text with `?` for unprintable letters; empty where the node has none."""
    try:
        data = sdo.read_bytes(index)
    except SdoRefused:
        return ""
    text = str(decode(data, "text"))
    return "".join(letter if letter.isprintable() else "?" for letter in text).strip()[:MAX_TEXT]
