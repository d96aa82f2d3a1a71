"""SDO (CiA 301, 7.2.4): what a server must do with good and with bad requests."""

from __future__ import annotations

from binascii import crc_hqx
from contextlib import contextmanager
from typing import TYPE_CHECKING

from omnimate.driver.conformance.probe import (
    NO_OBJECT,
    NO_SUBINDEX,
    READ_ONLY,
    WRONG_COMMAND,
    WRONG_CRC,
    WRONG_LENGTH,
    WRONG_TOGGLE,
    AbortedError,
    AbsentError,
    ConformanceError,
    expect,
    expect_code,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

    from omnimate.driver.conformance.probe import Probe

HEARTBEAT_TIME = 0x1017  # a writable object of 2 bytes that nearly every device has
LONG_TEXT = 0x1008  # an object of more than 4 bytes that most devices have
CLIENT_ABORT = b"\x80" + LONG_TEXT.to_bytes(2, "little") + b"\0" + (0x08000000).to_bytes(4, "little")


def expedited_upload(probe: Probe) -> None:
    """An object of 4 bytes is uploaded expedited; where a size is given it is right."""
    answer = probe.dialogue(0x1000, 0, 0x40)
    expect(answer[0] & 0xE2 == 0x42, f"answer {answer[0]:02X}h; expected an expedited upload, 43h or 42h")
    expect(not answer[0] & 1 or answer[0] & 0x0C == 0, f"answer {answer[0]:02X}h; expected a size of 4")


def segmented_upload(probe: Probe) -> None:
    """A longer object is uploaded in segments, as long as was announced."""
    answer = _announced_upload(probe)
    size = int.from_bytes(answer[4:], "little") if answer[0] & 1 else None
    data = probe.read(LONG_TEXT)
    expect(size in {None, len(data)}, f"{size} bytes announced, {len(data)} came")


def toggle_error(probe: Probe) -> None:
    """A segment with the wrong toggle bit is aborted."""
    _long_upload(probe)
    with _aborted("a segment with the wrong toggle bit was answered", WRONG_TOGGLE):
        probe.segment(bytes([0x70]).ljust(8, b"\0"))


def absent_object(probe: Probe) -> None:
    """An absent object is refused as absent, reading and writing."""
    for command in (0x40, 0x23):
        expect_code(_abort_of(probe, 0x2FFF, 0, command), NO_OBJECT)


def absent_subindex(probe: Probe) -> None:
    """An absent sub-index of a record that exists is refused as absent."""
    expect_code(_abort_of(probe, 0x1018, 0x7F, 0x40), NO_SUBINDEX)


def read_only(probe: Probe) -> None:
    """An object that is only read refuses to be written."""
    expect_code(probe.refusal(0x1000, 0, probe.need(0x1000), 4), READ_ONLY)


def short_download(probe: Probe) -> None:
    """A download of fewer bytes than the object has is refused, and changes nothing."""
    _refused_length(probe, 1)


def long_download(probe: Probe) -> None:
    """A download of more bytes than the object has is refused, and changes nothing."""
    _refused_length(probe, 4)


def download_without_size(probe: Probe) -> None:
    """An expedited download that states no size is taken with the size of the object."""
    with _restored_heartbeat_time(probe):
        probe.dialogue(HEARTBEAT_TIME, 0, 0x22, (2000).to_bytes(2, "little"))
        _expect_heartbeat_time(probe, 2000)


def segmented_download(probe: Probe) -> None:
    """An object of 2 bytes may be downloaded in one segment."""
    with _restored_heartbeat_time(probe):
        probe.dialogue(HEARTBEAT_TIME, 0, 0x21, (2).to_bytes(4, "little"))
        probe.segment(b"\x0b" + (2000).to_bytes(2, "little") + bytes(5))
        _expect_heartbeat_time(probe, 2000)


def short_segments(probe: Probe) -> None:
    """A segmented download that ends before the announced size is refused."""
    accepted = "one byte of two that were announced was accepted"
    with _restored_heartbeat_time(probe), _aborted(accepted, *WRONG_LENGTH):
        probe.dialogue(HEARTBEAT_TIME, 0, 0x21, (2).to_bytes(4, "little"))
        probe.segment(b"\x0d" + b"\x10" + bytes(6))


def unknown_command(probe: Probe) -> None:
    """A command specifier that does not exist is aborted."""
    expect_code(_abort_of(probe, 0x1000, 0, 0xE0), WRONG_COMMAND)


def stray_segment(probe: Probe) -> None:
    """A segment without a transfer under way is aborted."""
    with _aborted("a segment of no transfer was answered", WRONG_COMMAND):
        probe.segment(bytes([0x60]).ljust(8, b"\0"))


def short_request(probe: Probe) -> None:
    """A request of fewer than 8 bytes is not answered, and the next one is."""
    answer = probe.ask(b"\x40\x00\x10\x00")
    expect(answer is None, f"a request of 4 bytes was answered with {(answer or b'').hex()}")
    probe.read(0x1000)


def client_abort(probe: Probe) -> None:
    """The client's abort ends a transfer without an answer."""
    _long_upload(probe)
    answer = probe.ask(CLIENT_ABORT)
    expect(answer is None, f"an abort was answered with {(answer or b'').hex()}")
    stray_segment(probe)


def block_upload(probe: Probe) -> None:
    """A block upload gives the bytes that segments give, with the right CRC."""
    _announced_upload(probe)
    expected = probe.read(LONG_TEXT)
    try:
        answer = probe.dialogue(LONG_TEXT, 0, 0xA4, bytes([127, 0]))
    except AbortedError as aborted:
        expect_code(aborted.code, WRONG_COMMAND)
        raise AbsentError("no block upload; refused with 05040001h") from aborted
    if answer[0] & 0xE0 == 0x40:
        raise AbsentError("no block upload; answered by segments")
    probe.send_sdo(b"\xa3".ljust(8, b"\0"))
    data = b""
    for number in range(1, 128):
        part = probe.await_sdo()
        if part is None or part[0] & 0x7F != number:
            raise ConformanceError(f"no segment {number} of the block")
        data += part[1:]
        if part[0] & 0x80:
            break
    end = probe.segment(bytes([0xA2, number, 127]).ljust(8, b"\0"))
    probe.send_sdo(b"\xa1".ljust(8, b"\0"))
    data = data[: len(data) - (end[0] >> 2 & 7)]
    expect(data == expected, f"block upload gave {data!r}; segments {expected!r}")
    if answer[0] & 0x04:
        crc = int.from_bytes(end[1:3], "little")
        expect(crc == crc_hqx(data, 0), f"CRC {crc:04X}h; expected {crc_hqx(data, 0):04X}h")


def block_download(probe: Probe) -> None:
    """A block download is taken, and one with a wrong CRC is refused."""
    with _restored_heartbeat_time(probe):
        data = (2000).to_bytes(2, "little")
        try:
            has_crc = _download_block(probe, data, crc_hqx(data, 0))
        except AbortedError as aborted:
            expect_code(aborted.code, WRONG_COMMAND)
            raise AbsentError("no block download; refused with 05040001h") from aborted
        _expect_heartbeat_time(probe, 2000)
        if has_crc:
            with _aborted("a block with a wrong CRC was accepted", WRONG_CRC):
                _download_block(probe, data, crc_hqx(data, 0) ^ 1)


def _download_block(probe: Probe, data: bytes, crc: int) -> bool:
    """Download 1017h in one block; return whether the device checks the CRC."""
    answer = probe.dialogue(HEARTBEAT_TIME, 0, 0xC6, len(data).to_bytes(4, "little"))
    expect(answer[0] & 0xE3 == 0xA0, f"answer {answer[0]:02X}h; expected A0h or A4h")
    part = probe.segment(b"\x81" + data.ljust(7, b"\0"))
    expect(part[:2] == b"\xa2\x01", f"answer {part[:2].hex()} to the block; expected a201")
    end = probe.segment(bytes([0xC1 | (7 - len(data)) << 2]) + crc.to_bytes(2, "little") + bytes(5))
    expect(end[0] == 0xA1, f"answer {end[0]:02X}h to the end of the block; expected A1h")
    return bool(answer[0] & 0x04)


def _long_upload(probe: Probe) -> bytes:
    """Begin a segmented upload and return its first answer."""
    try:
        answer = probe.dialogue(LONG_TEXT, 0, 0x40)
    except AbortedError as aborted:
        raise AbsentError("no 1008h, so that no object of more than 4 bytes is known") from aborted
    if answer[0] & 0x02:
        raise AbsentError("1008h has 4 bytes or fewer, so that no longer object is known")
    return answer


def _announced_upload(probe: Probe) -> bytes:
    """Begin a segmented upload, end it, and return its first answer.

    A server may refuse to begin another while a transfer is under way, as CANopenNode does.
    """
    answer = _long_upload(probe)
    probe.send_sdo(CLIENT_ABORT)
    return answer


@contextmanager
def _aborted(otherwise: str, *codes: int) -> Iterator[None]:
    """Raise ConformanceError unless the block is aborted with one of some codes."""
    try:
        yield
    except AbortedError as aborted:
        expect_code(aborted.code, *codes)
    else:
        raise ConformanceError(otherwise)


def _abort_of(probe: Probe, index: int, subindex: int, command: int) -> int | None:
    try:
        probe.dialogue(index, subindex, command)
    except AbortedError as aborted:
        return aborted.code
    return None


def _refused_length(probe: Probe, size: int) -> None:
    with _restored_heartbeat_time(probe) as before:
        expect_code(probe.refusal(HEARTBEAT_TIME, 0, 2000, size), *WRONG_LENGTH)
        period = probe.need(HEARTBEAT_TIME)
        expect(period == before, f"1017h became {period} all the same")


@contextmanager
def _restored_heartbeat_time(probe: Probe) -> Iterator[int]:
    """Yield 1017h [ms] and write it back at the end; raise AbsentError where there is none."""
    before = probe.need(HEARTBEAT_TIME)
    with probe.restoring((HEARTBEAT_TIME, 0, 2)):
        yield before


def _expect_heartbeat_time(probe: Probe, written: int) -> None:
    period = probe.need(HEARTBEAT_TIME)
    expect(period == written, f"1017h is {period}; {written} was written")
