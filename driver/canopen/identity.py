"""Checks that a node is the device that `vehicle.toml` means, and reads what it reports about itself."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.driver.errors import NodeMissing, SdoSilent, TwoDevices, WrongDevice

if TYPE_CHECKING:
    from collections.abc import Sequence

    from omnimate.driver.canopen.notes import Notes
    from omnimate.driver.canopen.sdo import Sdo
    from omnimate.vehicle.parameters import Encoder

SECOND_ANSWERS = 2  # to four requests: one may be a device's mistake
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


def check_identity(sdo: Sdo, names: Sequence[str], encoder: Encoder | None, notes: Notes) -> None:
    """Check 1000h and 1018h of a node against its encoder's entry in `vehicle.toml`.

    Args:
        sdo: Objects of the node.
        names: Channels that the node should measure, or drives that it should contain.
        encoder: Encoder whose profile, vendor, product and serial number are expected; None for a drive, of
            which only the presence is checked.
        notes: Notes to add to.

    Raises:
        NodeMissing: The node does not answer.
        TwoDevices: Two devices answer.
        WrongDevice: The node has another profile, vendor, product or serial number.
        SdoSilent: The node stops answering.
    """
    try:
        device_type = sdo.find(0x1000) or 0
    except SdoSilent as silent:
        raise NodeMissing(sdo.node, names) from silent
    check_alone(sdo)
    notes.read.append(f"device type 1000h = {device_type:08X}h")
    if encoder is None:
        return
    _check_profile(sdo.node, device_type & 0xFFFF, encoder, notes)
    for subindex, key in IDENTITY:
        value = sdo.find(0x1018, subindex)
        if value is not None:
            notes.read.append(f"{key} 1018h:{subindex:02X} = {value}")
        _check_value(sdo, f"1018h:{subindex:02X}", key, getattr(encoder, key), value, notes)


def check_alone(sdo: Sdo) -> None:
    """Check that one device answers under this node id: each request has one answer.

    Raises:
        TwoDevices: Two of three requests were answered twice.
        SdoSilent: The node stops answering.
    """
    sdo.client.count_anew()
    for subindex in range(1, 5):
        sdo.find(0x1018, subindex)
    if sdo.client.second_answers >= SECOND_ANSWERS:
        raise TwoDevices(sdo.node)


def read_encoder(sdo: Sdo, encoders: Sequence[Encoder], notes: Notes) -> dict[int, int]:
    """Return the values of the optional objects that a CiA 406 encoder has, by index.

    Raises:
        SdoSilent: The node stops answering.
    """
    values: dict[int, int] = {}
    for index, name in ENCODER_OBJECTS:
        value = sdo.find(index)
        if value is not None:
            values[index] = value
            notes.read.append(f"{name} {index:04X}h = {value}")
    if values.get(0x6509):
        notes.remarks.append(
            f"offset 6509h = {values[0x6509]}: the position has been preset; is `zero` still right?"
        )
    units = values.get(0x6001)
    for encoder in encoders:
        if units and encoder.counts_per_turn is not None and encoder.counts_per_turn % units:
            notes.remarks.append(
                f"{encoder.channel}: counts_per_turn {encoder.counts_per_turn:g} is no multiple of the "
                f"{units} units per turn in 6001h; is that the gear?"
            )
    return values


def _check_profile(node: int, profile: int, encoder: Encoder, notes: Notes) -> None:
    if profile not in PROFILES:
        notes.remarks.append(
            f"1000h states profile {profile}; taken for {encoder.profile} as vehicle.toml says"
        )
    elif PROFILES[profile] != encoder.profile:
        raise WrongDevice(node, "1000h", "profile", encoder.profile, PROFILES[profile])


def _check_value(
    sdo: Sdo, where: str, key: str, expected: int | None, value: int | None, notes: Notes
) -> None:
    if expected is None:
        return
    if value is None and key == "serial":
        value, where = sdo.find(0x650B), "650Bh"
        notes.remarks.append("no serial number in 1018h:04; 650Bh is compared instead")
    if value != expected:
        actual = "missing" if value is None else str(value)
        raise WrongDevice(sdo.node, where, key, str(expected), actual)
