"""Checks by the profiles of encoders (CiA 406) and drives (CiA 402); no drive is energised."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.driver.canopen.cia402 import DISABLE_VOLTAGE, FAULT_MASK, READY, SHUTDOWN, STATE_MASK
from omnimate.driver.conformance.probe import (
    INVALID_VALUE,
    READ_ONLY,
    VALUE_TOO_HIGH,
    AbsentError,
    expect,
    expect_code,
)
from omnimate.files.logs.canopen_words import NMT_PRE_OPERATIONAL, NMT_START

if TYPE_CHECKING:
    from omnimate.driver.conformance.probe import Probe

# Mandatory objects and their bytes: CiA 406-1 class 1 and 2; CiA 402-2 for velocity modes.
ENCODER_OBJECTS = {0x6000: 2, 0x6004: 4, 0x6500: 2, 0x6501: 4, 0x6503: 2, 0x6504: 2, 0x6505: 2, 0x6506: 2}
DRIVE_OBJECTS = {0x603F: 2, 0x6040: 2, 0x6041: 2, 0x6060: 1, 0x6061: 1, 0x6502: 4}
DISABLED = 0x40  # status word 6041h under `FAULT_MASK`: switch on disabled (CiA 402-2)


def encoder_objects(probe: Probe) -> None:
    """The mandatory objects of an encoder are there, of their sizes."""
    _profile(probe, 406)
    _objects(probe, ENCODER_OBJECTS)


def encoder_position(probe: Probe) -> None:
    """The position 6004h is only read, and lies within 6002h."""
    _profile(probe, 406)
    position = probe.need(0x6004)
    expect_code(probe.refusal(0x6004, 0, 0, 4), READ_ONLY)
    total = probe.find(0x6002)
    expect(
        not total or position <= total or position >= 1 << 31, f"6004h = {position} exceeds 6002h = {total}"
    )


def encoder_timer(probe: Probe) -> None:
    """The cyclic timer 6200h is the event timer of TPDO1."""
    _profile(probe, 406)
    probe.need(0x6200)
    probe.nmt(NMT_PRE_OPERATIONAL)
    with probe.restoring((0x6200, 0, 2)):
        probe.write(0x6200, 0, 50, 2)
        expect(probe.find(0x1800, 5) in {None, 50}, f"1800h:05 is {probe.find(0x1800, 5)} at 6200h = 50")


def drive_objects(probe: Probe) -> None:
    """The mandatory objects of a drive are there, of their sizes."""
    _profile(probe, 402)
    _objects(probe, DRIVE_OBJECTS)


def drive_read_only(probe: Probe) -> None:
    """Status word, mode display and error code are only read."""
    _profile(probe, 402)
    for index, size in ((0x6041, 2), (0x6061, 1), (0x603F, 2)):
        if probe.find(index) is not None:
            expect_code(probe.refusal(index, 0, 0, size), READ_ONLY)


def drive_states(probe: Probe) -> None:
    """Shutdown leads from switch on disabled to ready to switch on, and disable voltage back."""
    _profile(probe, 402)
    probe.nmt(NMT_START)
    try:
        probe.write(0x6040, 0, DISABLE_VOLTAGE, 2)
        before = probe.need(0x6041) & FAULT_MASK
        if before != DISABLED:
            raise AbsentError(
                f"status word {probe.need(0x6041):04X}h: the drive is not in switch on disabled"
            )
        probe.write(0x6040, 0, SHUTDOWN, 2)
        probe.listen(0.1)
        ready = probe.need(0x6041)
        probe.write(0x6040, 0, DISABLE_VOLTAGE, 2)
        after = probe.need(0x6041)
    finally:
        probe.nmt(NMT_PRE_OPERATIONAL)
    expect(
        ready & STATE_MASK == READY, f"status word {ready:04X}h after shutdown; expected ready to switch on"
    )
    expect(after & FAULT_MASK == DISABLED, f"status word {after:04X}h after disable voltage")


def drive_modes(probe: Probe) -> None:
    """Modes of operation that 6502h does not list are refused."""
    _profile(probe, 402)
    supported = probe.need(0x6502)
    with probe.restoring((0x6060, 0, 1)):
        for mode in range(1, 11):
            if not supported >> (mode - 1) & 1:
                expect_code(probe.refusal(0x6060, 0, mode, 1), INVALID_VALUE, VALUE_TOO_HIGH)
                return


def _profile(probe: Probe, number: int) -> None:
    profile = probe.need(0x1000) & 0xFFFF
    if profile != number:
        raise AbsentError(f"1000h states profile {profile}, not {number}")


def _objects(probe: Probe, objects: dict[int, int]) -> None:
    problems = []
    for index, size in objects.items():
        if probe.find(index) is None:
            problems.append(f"no {index:04X}h")
        elif len(probe.read(index)) != size:
            problems.append(f"{index:04X}h has {len(probe.read(index))} bytes; expected {size}")
    expect(not problems, ", ".join(problems))
