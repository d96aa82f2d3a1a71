"""Is it the device that `vehicle.toml` means, and what does it say of itself?"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from driver.errors import NodeMissing, SdoSilent, WrongDevice

if TYPE_CHECKING:
    from collections.abc import Sequence

    from driver.sdo import Sdo
    from vehicle.parameters import Encoder

PROFILES = {406: "cia406", 402: "cia402"}
IDENTITY = ((1, "vendor"), (2, "product"), (4, "serial"))
# What a CiA 406 encoder may tell; all optional, all only read.
ENCODER_OBJECTS = (
    (0x6000, "operating parameters"),
    (0x6001, "units per turn"),
    (0x6500, "operating status"),
    (0x6501, "single-turn resolution"),
    (0x6502, "turns"),
    (0x6509, "offset"),
    (0x650B, "serial number"),
)


@dataclass(slots=True)
class Notes:
    """What is said about one node while it is configured.

    Attributes:
        found: as it was.
        changed: by the driver.
        remarks: that an operator should read.
    """

    found: list[str] = field(default_factory=list)
    changed: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)


def check_identity(sdo: Sdo, names: Sequence[str], encoder: Encoder | None, notes: Notes) -> None:
    """Check 1000h and 1018h of a node against its encoder's entry in `vehicle.toml`.

    Raises:
        NodeMissing: nobody answers.
        WrongDevice: another profile, vendor, product or serial number.
        SdoRefused, SdoSilent: the dialogue failed.
    """
    try:
        device_type = sdo.find(0x1000) or 0
    except SdoSilent as silent:
        raise NodeMissing(sdo.node, names) from silent
    notes.found.append(f"device type 1000h = {device_type:08X}h")
    if encoder is None:
        return
    _check_profile(sdo.node, device_type & 0xFFFF, encoder, notes)
    for subindex, key in IDENTITY:
        value = sdo.find(0x1018, subindex)
        if value is not None:
            notes.found.append(f"{key} 1018h:{subindex:02X} = {value}")
        _check_value(sdo, key, getattr(encoder, key), value, notes)


def read_encoder(sdo: Sdo, encoders: Sequence[Encoder], notes: Notes) -> dict[int, int]:
    """Return what a CiA 406 encoder tells of itself, by index.

    Raises:
        SdoRefused, SdoSilent: the dialogue failed.
    """
    read = ((index, name, sdo.find(index)) for index, name in ENCODER_OBJECTS)
    told = {index: (name, value) for index, name, value in read if value is not None}
    notes.found += [f"{name} {index:04X}h = {value}" for index, (name, value) in told.items()]
    values = {index: value for index, (_, value) in told.items()}
    if values.get(0x6509):
        notes.remarks.append(
            f"offset 6509h = {values[0x6509]}: the position has been preset; is `zero` still right?"
        )
    units = values.get(0x6001)
    for one in encoders:
        if units and one.counts_per_turn is not None and one.counts_per_turn % units:
            notes.remarks.append(
                f"{one.channel}: counts_per_turn {one.counts_per_turn:g} is no multiple of the "
                f"{units} units per turn in 6001h; is that the gear?"
            )
    return values


def choose_range(encoder: Encoder, said: int | None) -> tuple[int, str]:
    """Return the range by which a channel is unwrapped, and why, given what 6002h says.

    6002h means N for some vendors, N - 1 for others, and 0 means 2**32 for one.
    """
    own, full = encoder.wrap_range, 2**encoder.bits
    name = encoder.channel
    if said is None:
        return own, f"{name}: wraps at {own}; the device has no 6002h"
    if said == own:
        return own, f"{name}: wraps at {own}; 6002h says so and means N"
    if said == own - 1:
        return own, f"{name}: wraps at {own}; 6002h says {said} and means N - 1"
    if said == 0 and full == 2**32 and encoder.range is None:
        return full, f"{name}: wraps at 2**32; 6002h says 0"
    guess = said + said % 2
    if encoder.range is not None or not 1 < guess <= full:
        return (
            own,
            f"{name}: 6002h says {said}, but vehicle.toml {own}, which is used: check it",
        )
    means = "N - 1" if said % 2 else "N"
    return guess, f"{name}: wraps at {guess}; 6002h says {said}, taken for {means}; vehicle.toml says nothing"


def _check_profile(node: int, found: int, encoder: Encoder, notes: Notes) -> None:
    if found in PROFILES:
        if PROFILES[found] != encoder.profile:
            raise WrongDevice(node, "profile", encoder.profile, PROFILES[found])
    else:
        notes.remarks.append(
            f"1000h states profile {found}; taken for {encoder.profile} as vehicle.toml says"
        )


def _check_value(sdo: Sdo, key: str, expected: int | None, value: int | None, notes: Notes) -> None:
    if expected is None:
        return
    if value is None and key == "serial":
        value = sdo.find(0x650B)
        notes.remarks.append("no serial number in 1018h:04; 650Bh is compared instead")
    if value != expected:
        found = "no such object" if value is None else str(value)
        raise WrongDevice(sdo.node, key, str(expected), found)
