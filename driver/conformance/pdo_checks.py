"""PDOs (CiA 301, 7.2.2 and 7.5.2.35 to 7.5.2.38): when they are sent, and what their parameters take."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING

from omnimate.driver.canopen.pdo_parameters import INVALID, MAPPING, RPDO, TPDO
from omnimate.driver.conformance.probe import (
    DEVICE_STATE,
    INVALID_VALUE,
    NO_OBJECT,
    NOT_MAPPABLE,
    PDO_TOO_LONG,
    READ_ONLY,
    UNSUPPORTED_ACCESS,
    AbsentError,
    expect,
    expect_code,
)
from omnimate.files.logs.canopen_words import NMT_PRE_OPERATIONAL, NMT_START, SYNC_ID

if TYPE_CHECKING:
    from collections.abc import Iterator

    from omnimate.driver.conformance.probe import Probe

UNSUPPORTED = (UNSUPPORTED_ACCESS, READ_ONLY, INVALID_VALUE)  # a parameter that cannot be changed
ERROR_REGISTER = 0x10010008  # 1001h as an entry of a mapping: every device has it
SYNC_ANSWER = 0.1  # [s] to wait for the PDOs that answer one SYNC


def answers_sync(probe: Probe) -> None:
    """A TPDO of type 1 answers each SYNC once in the state operational, and in no other."""
    with _of_type(probe, 1) as cob_id:
        before = _answers(probe, cob_id)
        probe.nmt(NMT_START)
        counts = [_answers(probe, cob_id) for _ in range(3)]
    expect(before == 0, f"{before} PDOs in the state pre-operational")
    expect(counts == [1, 1, 1], f"{counts} PDOs to three SYNCs; expected one each")


def every_third_sync(probe: Probe) -> None:
    """A TPDO of type 3 answers every third SYNC."""
    with _of_type(probe, 3) as cob_id:
        probe.nmt(NMT_START)
        count = sum(_answers(probe, cob_id) for _ in range(6))
    expect(count == 2, f"{count} PDOs to six SYNCs; expected 2")


def reserved_types(probe: Probe) -> None:
    """The transmission types 241 to 251 are refused."""
    _tpdo(probe)
    with _saved(probe, TPDO):
        for kind in (241, 251):
            expect_code(probe.refusal(TPDO, 2, kind, 1), *UNSUPPORTED)


def switched_off(probe: Probe) -> None:
    """A TPDO with bit 31 of its COB-ID set is not sent."""
    cob_id = _tpdo(probe)
    with _saved(probe, TPDO):
        code = probe.refusal(TPDO, 1, cob_id | INVALID, 4)
        if code is not None:
            raise AbsentError(f"bit 31 of the COB-ID is refused with {code:08X}h")
        probe.nmt(NMT_START)
        count = _answers(probe, cob_id)
    expect(count == 0, f"{count} PDOs although it is switched off")


def cob_id_while_valid(probe: Probe) -> None:
    """The COB-ID of a valid TPDO cannot be changed."""
    cob_id = _tpdo(probe)
    with _saved(probe, TPDO):
        probe.refusal(TPDO, 1, cob_id & ~INVALID, 4)
        expect_code(probe.refusal(TPDO, 1, (cob_id & ~INVALID) ^ 0x400, 4), *UNSUPPORTED, DEVICE_STATE)


def mapping_order(probe: Probe) -> None:
    """An entry of a mapping that is in use cannot be changed."""
    _need_mapping(probe)
    with _saved(probe, TPDO):
        code = probe.refusal(TPDO + MAPPING, 1, ERROR_REGISTER, 4)
        expect(code is not None, "an entry was changed while the mapping is in use")


def mapping_changes(probe: Probe) -> None:
    """A mapping is changed in the order of CiA 301, and the PDO has the new length."""
    cob_id = _need_mapping(probe)
    with _emptied(probe, cob_id):
        code = probe.refusal(TPDO + MAPPING, 1, ERROR_REGISTER, 4)
        if code is not None:
            raise AbsentError(f"1001h cannot be mapped: {code:08X}h")
        probe.write(TPDO + MAPPING, 0, 1, 1)
        probe.refusal(TPDO, 2, 1, 1)
        probe.write(TPDO, 1, cob_id & ~INVALID, 4)
        probe.nmt(NMT_START)
        probe.send(SYNC_ID)
        data = probe.await_frame(cob_id & 0x7FF, SYNC_ANSWER)
    expect(data is None or len(data) == 1, f"a PDO of {len(data or b'')} bytes; expected 1")


def mapping_of_nothing(probe: Probe) -> None:
    """An object that does not exist cannot be mapped."""
    cob_id = _need_mapping(probe)
    with _emptied(probe, cob_id):
        code = probe.refusal(TPDO + MAPPING, 1, 0x2FFF0008, 4)
        if code is None:
            code = probe.refusal(TPDO + MAPPING, 0, 1, 1)
    expect_code(code, NO_OBJECT, NOT_MAPPABLE)


def mapping_too_long(probe: Probe) -> None:
    """More than 8 bytes cannot be mapped."""
    cob_id = _need_mapping(probe)
    entry = probe.need(TPDO + MAPPING, 1)
    copies = 64 // (entry & 0xFF) + 1 if entry & 0xFF else 0
    with _emptied(probe, cob_id):
        codes = [probe.refusal(TPDO + MAPPING, number, entry, 4) for number in range(1, copies + 1)]
        if not copies or any(code not in {None, PDO_TOO_LONG} for code in codes):
            raise AbsentError("the mapping cannot hold its first object often enough")
        code = PDO_TOO_LONG if PDO_TOO_LONG in codes else probe.refusal(TPDO + MAPPING, 0, copies, 1)
    expect_code(code, PDO_TOO_LONG)


def event_timer(probe: Probe) -> None:
    """A TPDO of type 255 is sent by its event timer."""
    cob_id = _tpdo(probe)
    if probe.find(TPDO, 5) is None:
        raise AbsentError("no 1800h:05")
    with _saved(probe, TPDO):
        probe.refusal(TPDO, 1, cob_id | INVALID, 4)
        codes = [probe.refusal(TPDO, 2, 255, 1), probe.refusal(TPDO, 5, 100, 2)]
        if codes != [None, None]:
            raise AbsentError("type 255 or the event timer is refused")
        probe.refusal(TPDO, 1, cob_id & ~INVALID, 4)
        probe.nmt(NMT_START)
        count = len(probe.heard(cob_id & 0x7FF, 0.55))
    expect(4 <= count <= 8, f"{count} PDOs in 0.55 s with an event timer of 100 ms")


def rpdo_length(probe: Probe) -> None:
    """An RPDO that is too short causes EMCY 8210h and is not taken."""
    cob_id = probe.need(RPDO, 1)
    length = sum(
        (probe.find(RPDO + MAPPING, n) or 0) & 0xFF for n in range(1, probe.need(RPDO + MAPPING) + 1)
    )
    if cob_id & INVALID or length <= 8:
        raise AbsentError("RPDO1 is switched off or has one byte")
    probe.nmt(NMT_START)
    probe.listen(0.0)
    probe.send(cob_id & 0x7FF, b"\0")
    codes = [reply.data[:2] for reply in probe.heard(0x80 + probe.node, SYNC_ANSWER)]
    probe.nmt(NMT_PRE_OPERATIONAL)
    expect(b"\x10\x82" in codes, f"EMCY {[code.hex() for code in codes]}; expected 8210h")


def _tpdo(probe: Probe) -> int:
    """Return the COB-ID of TPDO1 with its upper bits; raise AbsentError where there is none to be sent."""
    cob_id = probe.need(TPDO, 1)
    if not probe.need(TPDO + MAPPING):
        raise AbsentError("TPDO1 maps nothing")
    return cob_id


def _need_mapping(probe: Probe) -> int:
    cob_id = _tpdo(probe)
    with _saved(probe, TPDO):
        probe.refusal(TPDO, 1, cob_id | INVALID, 4)
        code = probe.refusal(TPDO + MAPPING, 0, 0, 1)
    if code is not None:
        raise AbsentError(f"the mapping of TPDO1 is fixed: {code:08X}h")
    return cob_id


def _answers(probe: Probe, cob_id: int) -> int:
    """Send SYNC and return how many frames of a PDO follow."""
    probe.listen(0.0)
    probe.send(SYNC_ID)
    return len(probe.heard(cob_id & 0x7FF, SYNC_ANSWER))


@contextmanager
def _of_type(probe: Probe, kind: int) -> Iterator[int]:
    """Give TPDO1 a transmission type for a while; yield its COB-ID."""
    cob_id = _tpdo(probe)
    with _saved(probe, TPDO):
        probe.refusal(TPDO, 1, cob_id | INVALID, 4)
        code = probe.refusal(TPDO, 2, kind, 1)
        if code is not None:
            raise AbsentError(f"transmission type {kind} is refused with {code:08X}h")
        probe.refusal(TPDO, 1, cob_id & ~INVALID, 4)
        yield cob_id


@contextmanager
def _emptied(probe: Probe, cob_id: int) -> Iterator[None]:
    with _saved(probe, TPDO):
        probe.refusal(TPDO, 1, cob_id | INVALID, 4)
        probe.refusal(TPDO + MAPPING, 0, 0, 1)
        yield


@contextmanager
def _saved(probe: Probe, base: int) -> Iterator[None]:
    """Enter pre-operational, and put all parameters of a PDO back at the end."""
    probe.nmt(NMT_PRE_OPERATIONAL)
    cob_id = probe.need(base, 1)
    kept = [(base, sub, size, probe.find(base, sub)) for sub, size in ((2, 1), (3, 2), (5, 2))]
    count = probe.need(base + MAPPING)
    entries = [probe.find(base + MAPPING, number) for number in range(1, count + 1)]
    try:
        yield
    finally:
        probe.nmt(NMT_PRE_OPERATIONAL)
        probe.refusal(base, 1, cob_id | INVALID, 4)
        for index, subindex, size, value in kept:
            if value is not None and probe.find(index, subindex) != value:
                probe.refusal(index, subindex, value, size)
        now = [
            probe.find(base + MAPPING, number) for number in range(1, (probe.find(base + MAPPING) or 0) + 1)
        ]
        if now != entries:
            probe.refusal(base + MAPPING, 0, 0, 1)
            for number, entry in enumerate(entries, start=1):
                probe.refusal(base + MAPPING, number, entry or 0, 4)
            probe.refusal(base + MAPPING, 0, count, 1)
        probe.refusal(base, 1, cob_id, 4)
