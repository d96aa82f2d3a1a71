"""Steps that configuring encoders and drives share: reach the node, check its identity, set its heartbeat."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from omnimate.driver.errors import NodeMissing, NotTaken, SdoRefused, SdoSilent, TwoDevices, WrongDevice
from omnimate.files.logs.canopen_words import NMT_PRE_OPERATIONAL, NMT_RESET_COMMUNICATION

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from omnimate.driver.canopen.sdo import Sdo
    from omnimate.vehicle.parameters import Channel, Encoder

MIN_DUPLICATES = 2  # of four requests: one may be a device's mistake
PROFILES = {406: "cia406", 402: "cia402"}
IDENTITY = ((1, "vendor"), (2, "product"), (4, "serial"))
# What a CiA 406 encoder may report; all optional, all only read.
ENCODER_OBJECTS = (
    (0x6000, "operating parameters"),
    (0x6001, "units per turn"),
    (0x6500, "operating status"),
    (0x6501, "single-turn resolution"),
    (0x6502, "turns"),
    (0x6509, "offset"),
    (0x650B, "serial number"),
)
# Choices of the driver; CiA 301 leaves 1017h free from 1 ms on.
HEARTBEAT_MS = 500  # [ms] producer heartbeat time 1017h of an encoder
DRIVE_HEARTBEAT_MS = 25  # [ms] of a drive: lost after three of them, it stops the robot within 100 ms
SHORTEST_MS, LONGEST_MS = 10, 2000  # [ms] a heartbeat period in this range is left as it is
# A stopped node has no SDO; NMT brings it back (CiA 301).
_REMEDIES = (
    (NMT_PRE_OPERATIONAL, "set pre-operational"),
    (NMT_RESET_COMMUNICATION, "its communication reset"),
)


@dataclass(slots=True)
class NodeConfiguration:
    """What was read at one node, what was changed, and what an operator should check."""

    node: int  # CANopen node id
    names: tuple[str, ...]  # channels that the node measures, or wheels that it drives
    read: list[str] = field(default_factory=list)  # what was read before anything was changed, one line each
    # what the driver changed, one line each; empty where all was right
    changed: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)  # what an operator should check, one line each
    # range by which each channel is unwrapped [counts]
    ranges: dict[Channel, int] = field(default_factory=dict)
    lengths: dict[int, int] = field(default_factory=dict)  # bytes of each PDO of the node, by COB-ID
    timed: set[int] = field(default_factory=set)  # COB-IDs of those that are sent by the device's own timer
    heartbeat: float | None = None  # heartbeat period [s]; None where the node has none
    # values that a CiA 406 encoder reports about itself, by index, such as the offset 6509h and the serial
    # number 650Bh
    encoder_objects: dict[int, int] = field(default_factory=dict)
    woken: str | None = None  # what it took to have the node answer, in words; None where it answered

    def lines(self) -> tuple[tuple[str, str], ...]:
        """Return each line with its kind: found, changed or remark."""
        changed = [*self.changed, self.woken] if self.woken else self.changed
        kinds = (("found", self.read), ("changed", changed), ("remark", self.remarks))
        return tuple((kind, line) for kind, lines in kinds for line in lines)


def wake(sdo: Sdo, nmt: Callable[[int, int], None]) -> str | None:
    """Bring a node that does not answer SDO back by NMT, if that is possible; return how, in words.

    None where the node answered at once, or does not answer all the same. Raises BusLost.
    """
    if sdo.answers():
        return None
    for command, words in _REMEDIES:
        nmt(command, sdo.node)
        if sdo.answers():
            return f"did not answer SDO, as in NMT state stopped: {words}"
    return None


def check_identity(sdo: Sdo, encoder: Encoder | None, configuration: NodeConfiguration) -> None:
    """Check 1000h and 1018h of a node against its encoder in `vehicle.toml`; of a drive, its presence.

    Raises NodeMissing, TwoDevices or SdoSilent, and WrongDevice for another profile, vendor, product or
    serial number.
    """
    try:
        device_type = sdo.find(0x1000) or 0
    except SdoSilent as silent:
        raise NodeMissing(sdo.node, configuration.names) from silent
    check_alone(sdo)
    configuration.read.append(f"device type 1000h = {device_type:08X}h")
    if encoder is None:
        return
    _check_profile(device_type & 0xFFFF, encoder, configuration)
    for subindex, key in IDENTITY:
        value = sdo.find(0x1018, subindex)
        if value is not None:
            configuration.read.append(f"{key} 1018h:{subindex:02X} = {value}")
        _check_value(sdo, f"1018h:{subindex:02X}", key, getattr(encoder, key), value, configuration)


def check_alone(sdo: Sdo) -> None:
    """Check that one device answers under this node id; raises SdoSilent, or TwoDevices where two do.

    Each request has one answer; `MIN_DUPLICATES` of four show a second device.
    """
    sdo.reset_duplicate_answers()
    for subindex in range(1, 5):
        sdo.find(0x1018, subindex)
    if sdo.duplicate_answers >= MIN_DUPLICATES:
        raise TwoDevices(sdo.node)


def read_encoder(sdo: Sdo, encoders: Sequence[Encoder], configuration: NodeConfiguration) -> None:
    """Read the optional objects that a CiA 406 encoder has into `configuration.encoder_objects`.

    Raises SdoSilent.
    """
    values = configuration.encoder_objects
    for index, name in ENCODER_OBJECTS:
        value = sdo.find(index)
        if value is not None:
            values[index] = value
            configuration.read.append(f"{name} {index:04X}h = {value}")
    if values.get(0x6509):
        configuration.remarks.append(
            f"offset 6509h = {values[0x6509]}: the position has been preset; is `zero` still right?"
        )
    units = values.get(0x6001)
    for encoder in encoders:
        if units and encoder.counts_per_turn is not None and encoder.counts_per_turn % units:
            configuration.remarks.append(
                f"{encoder.channel}: counts_per_turn {encoder.counts_per_turn:g} is no multiple of the "
                f"{units} units per turn in 6001h; is that the gear?"
            )


def _check_profile(profile: int, encoder: Encoder, configuration: NodeConfiguration) -> None:
    if profile not in PROFILES:
        configuration.remarks.append(
            f"1000h states profile {profile}; taken for {encoder.profile} as vehicle.toml says"
        )
    elif PROFILES[profile] != encoder.profile:
        raise WrongDevice(configuration.node, "1000h", "profile", encoder.profile, PROFILES[profile])


def _check_value(
    sdo: Sdo, where: str, key: str, expected: int | None, value: int | None, configuration: NodeConfiguration
) -> None:
    if expected is None:
        return
    if value is None and key == "serial":
        value, where = sdo.find(0x650B), "650Bh"
        configuration.remarks.append("no serial number in 1018h:04; 650Bh is compared instead")
    if value != expected:
        actual = "missing" if value is None else str(value)
        raise WrongDevice(sdo.node, where, key, str(expected), actual)


def set_heartbeat(
    sdo: Sdo, configuration: NodeConfiguration, wanted: int = HEARTBEAT_MS, longest: int = LONGEST_MS
) -> None:
    """Have the node produce a heartbeat (1017h), and note its period in `configuration.heartbeat`.

    A heartbeat between `SHORTEST_MS` and `longest` [ms] is left as it is, and so is a node that refuses
    `wanted` [ms], with a remark. Raises SdoSilent.
    """
    period = sdo.find(0x1017)
    if period is None:
        configuration.remarks.append("no heartbeat (1017h); its silence shows in its PDOs alone")
        return
    configuration.heartbeat = period / 1000.0 or None
    if SHORTEST_MS <= period <= longest:
        configuration.read.append(f"heartbeat 1017h = {period} ms")
        return
    try:
        sdo.put(0x1017, 0, wanted)
    except (SdoRefused, NotTaken) as error:
        configuration.remarks.append(f"heartbeat stays at {period} ms: {error.problem}")
        return
    configuration.heartbeat = wanted / 1000.0
    configuration.changed.append(f"heartbeat 1017h: {period} ms to {wanted} ms")
