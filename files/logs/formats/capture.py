"""Captures of Wireshark and tcpdump with frames of SocketCAN: PCAP and PCAPNG, read and written.

A packet is what libpcap defines for LINKTYPE_CAN_SOCKETCAN: identifier with the flags of linux/can.h in
network order, length, CAN FD bits, two bytes of nothing, and the data. PCAPNG keeps the names of interfaces
and whether a frame was sent; PCAP does not. Captures on all interfaces (LINKTYPE_LINUX_SLL) are read, too.

Sources: https://www.tcpdump.org/linktypes/LINKTYPE_CAN_SOCKETCAN.html and LINKTYPE_LINUX_SLL.html,
draft-ietf-opsawg-pcap, draft-ietf-opsawg-pcapng.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, BinaryIO, Literal, NamedTuple

from omnimate.files.logs.formats.candump_blocks import SkippedLine
from omnimate.files.logs.formats.candump_lines import (
    CANFD_FDF,
    ERROR_BIT,
    FD_LENGTHS,
    fd_bits,
    fd_flags,
    refuse_fd,
)
from omnimate.files.logs.frames import (
    DEFAULT_CHANNEL,
    ERROR,
    EXTENDED,
    FD,
    NANOSECOND,
    RECEIVED,
    REMOTE,
    SENT,
    Frame,
    nanoseconds,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

CaptureFormat = Literal["pcap", "pcapng"]

LINK_TYPE = 227  # LINKTYPE_CAN_SOCKETCAN
COOKED = 113  # LINKTYPE_LINUX_SLL, of a capture on all interfaces
EXTENDED_BIT, REMOTE_BIT = 0x80000000, 0x40000000  # CAN_EFF_FLAG and CAN_RTR_FLAG of linux/can.h
ALL_BITS = 0x1FFFFFFF

_PACKET = struct.Struct(">IBBxx")
_FD_PACKET = 72  # bytes, as Linux hands a CAN FD frame on
_COOKED_HEAD = struct.Struct(">H12xH")  # packet type, ..., protocol
_COOKED_CAN = (0x000C, 0x000D)  # protocols LINUX_SLL_P_CAN and LINUX_SLL_P_CANFD
_COOKED_SENT = 4  # packet type: sent by us
_TICKS = {0xA1B2C3D4: 1_000_000, 0xA1B23C4D: NANOSECOND}  # per second, by the first word of a PCAP file
_SNAP_LENGTH = 262_144  # bytes: the largest packet that libpcap takes
_MAX_BLOCK_SIZE = 1 << 24  # bytes of a block; a larger one is a damaged length
_SECTION, _INTERFACE, _ENHANCED, _SIMPLE = 0x0A0D0D0A, 1, 6, 3  # block types of PCAPNG
_ORDER_MAGIC = 0x1A2B3C4D
_IF_NAME, _IF_RESOLUTION, _EPB_FLAGS = 2, 9, 2  # options
_INBOUND, _OUTBOUND = 1, 2  # direction in epb_flags
_DIRECTIONS = {_INBOUND: RECEIVED, _OUTBOUND: SENT}


def capture_format_of(head: bytes) -> CaptureFormat | None:
    """Return the format that the first bytes of a file show; None for none of these."""
    if head[:4] == _SECTION.to_bytes(4, "big"):
        return "pcapng"
    is_pcap = {int.from_bytes(head[:4], "big"), int.from_bytes(head[:4], "little")} & _TICKS.keys()
    return "pcap" if is_pcap else None


def packet_of(frame: Frame) -> bytes:
    """Return a frame as a packet of SocketCAN."""
    bits = frame.can_id
    bits |= EXTENDED_BIT if frame.flags & EXTENDED else 0
    bits |= REMOTE_BIT if frame.flags & REMOTE else 0
    bits |= ERROR_BIT if frame.flags & ERROR else 0
    fd = fd_bits(frame.flags) | CANFD_FDF if frame.flags & FD else 0
    return _PACKET.pack(bits, frame.size, fd) + frame.data


def frame_of_packet(
    packet: bytes, time: float, channel: str = DEFAULT_CHANNEL, direction: int = 0
) -> Frame | str:
    """Return the frame in a packet of SocketCAN, or the reason why it holds none."""
    if len(packet) < _PACKET.size:
        return f"a packet of {len(packet)} bytes; expected {_PACKET.size} or more"
    bits, length, fd = _PACKET.unpack_from(packet)
    data = packet[_PACKET.size : _PACKET.size + length]
    is_fd = bool(fd & CANFD_FDF) or length > 8 or len(packet) == _FD_PACKET  # older kernels set no bit
    kind = ERROR if bits & ERROR_BIT else EXTENDED if bits & EXTENDED_BIT else 0
    kind |= fd_flags(fd) if is_fd else 0
    if kind & EXTENDED == 0 and not kind & ERROR and bits & ALL_BITS > 0x7FF:
        return f"{bits & ALL_BITS:X} is not an identifier of 11 bits"
    if length not in FD_LENGTHS:
        return f"{length} bytes of data; a frame has 0 to 8, or 12, 16, 20, 24, 32, 48, 64 with CAN FD"
    if bits & REMOTE_BIT:
        return Frame(time, bits & ALL_BITS, b"", kind | REMOTE | direction, length, channel)
    if len(data) != length:
        return f"the length says {length}, the number of bytes is {len(data)}"
    return Frame(time, bits & ALL_BITS, data, kind | direction, length, channel)


def read_capture(file: BinaryIO, *, fd: bool = True) -> Iterator[Frame | SkippedLine]:
    """Yield the frames of a PCAP or PCAPNG file, and the packets that hold none, by their numbers.

    Without `fd`, CAN FD frames are left out.
    """
    number = 0
    try:
        for number, frame in enumerate(_packets(file), start=1):
            result = refuse_fd(frame, fd=fd)
            yield SkippedLine(number, f"packet {number}", result) if isinstance(result, str) else result
    except EOFError:
        yield SkippedLine(number + 1, "", "", is_end=True)
    except _DamagedError as error:
        yield SkippedLine(number + 1, f"packet {number + 1}", str(error), is_end=True)


class _DamagedError(Exception):
    """A file that cannot be read on."""


def _packets(file: BinaryIO) -> Iterator[Frame | str]:
    magic = _read(file, 4)
    if magic == _SECTION.to_bytes(4, "big"):
        yield from _packets_of_pcapng(file)
        return
    order = "<" if int.from_bytes(magic, "little") in _TICKS else ">"
    ticks = _TICKS[struct.unpack(order + "I", magic)[0]]
    link_type = struct.unpack(order + "I", _read(file, 20)[16:])[0] & 0xFFFF
    record = struct.Struct(order + "IIII")
    if link_type not in {LINK_TYPE, COOKED}:
        raise _DamagedError(_other_link_type(link_type))
    while head := file.read(record.size):
        whole, rest, captured, _ = record.unpack(_require_size(head, record.size))
        packet = _read(file, _require_plausible(captured))
        yield _frame(packet, link_type, order, whole + rest / ticks, DEFAULT_CHANNEL)


def _frame(
    packet: bytes, link_type: int, order: str, time: float, channel: str, direction: int = 0
) -> Frame | str:
    """Return the frame in a packet of either link type, in a file of a byte order, or why it holds none."""
    if link_type == LINK_TYPE:
        return frame_of_packet(packet, time, channel, direction)
    if link_type != COOKED:
        return _other_link_type(link_type)
    if len(packet) < _COOKED_HEAD.size + _PACKET.size:
        return f"a packet of {len(packet)} bytes; expected {_COOKED_HEAD.size + _PACKET.size} or more"
    kind, protocol = _COOKED_HEAD.unpack_from(packet)
    if protocol not in _COOKED_CAN:
        return f"protocol {protocol:04X}h, which is not CAN"
    bits = struct.unpack_from(order + "I", packet, _COOKED_HEAD.size)[0]  # in the order of the host
    plain = struct.pack(">I", bits) + packet[_COOKED_HEAD.size + 4 :]
    return frame_of_packet(plain, time, channel, direction or (SENT if kind == _COOKED_SENT else 0))


class _Interface(NamedTuple):
    """What an interface description block says: name, clock, and kind of packets."""

    name: str
    ticks: int
    link_type: int


def _packets_of_pcapng(file: BinaryIO) -> Iterator[Frame | str]:
    """Yield the packets behind the first four bytes of a section header."""
    order, interfaces, kind = "<", list[_Interface](), _SECTION
    while True:
        if kind == _SECTION:
            order, body = _section(file)
            interfaces = []
        else:
            size = _require_plausible(struct.unpack(order + "I", _read(file, 4))[0])
            body = _read(file, max(size - 8, 0))[:-4]
        if kind == _INTERFACE:
            interfaces.append(_interface(body, order, len(interfaces)))
        elif kind == _ENHANCED:
            yield _enhanced(body, order, interfaces)
        elif kind == _SIMPLE:
            yield "a packet without a time (simple packet block)"
        head = file.read(4)
        if not head:
            return
        kind = struct.unpack(order + "I", _require_size(head, 4))[0]


def _section(file: BinaryIO) -> tuple[str, bytes]:
    """Return the byte order of a section, and the rest of its header."""
    size, magic = _read(file, 4), _read(file, 4)
    order = "<" if int.from_bytes(magic, "little") == _ORDER_MAGIC else ">"
    return order, _read(file, max(_require_plausible(struct.unpack(order + "I", size)[0]) - 12, 0))


def _interface(body: bytes, order: str, number: int) -> _Interface:
    options = _options(body[8:], order)
    resolution = options.get(_IF_RESOLUTION, b"\x06")[0]
    ticks = 2 ** (resolution & 0x7F) if resolution & 0x80 else 10 ** min(resolution, 18)
    name = "_".join(options.get(_IF_NAME, b"").decode(errors="replace").split())
    return _Interface(name or f"can{number}", ticks, struct.unpack_from(order + "H", body.ljust(2, b"\0"))[0])


def _enhanced(body: bytes, order: str, interfaces: list[_Interface]) -> Frame | str:
    head = struct.Struct(order + "IIIII")
    if len(body) < head.size:
        return "a block that is too short"
    number, high, low, captured, _ = head.unpack_from(body)
    if number >= len(interfaces):
        return f"interface {number} is not described"
    name, ticks, link_type = interfaces[number]
    end = head.size + captured
    flags = _options(body[end + -captured % 4 :], order).get(_EPB_FLAGS, b"\0")[0 if order == "<" else -1]
    time = (high << 32 | low) / ticks
    return _frame(body[head.size : end], link_type, order, time, name, _DIRECTIONS.get(flags & 3, 0))


def _options(data: bytes, order: str) -> dict[int, bytes]:
    options: dict[int, bytes] = {}
    place = 0
    while place + 4 <= len(data):
        code, length = struct.unpack_from(order + "HH", data, place)
        if code == 0:
            break
        if length:
            options[code] = data[place + 4 : place + 4 + length]
        place += 4 + length + -length % 4
    return {code: value for code, value in options.items() if value}


def _read(file: BinaryIO, size: int) -> bytes:
    return _require_size(file.read(size), size)


def _require_size(data: bytes, size: int) -> bytes:
    if len(data) < size:
        raise EOFError
    return data


def _require_plausible(size: int) -> int:
    if size > _MAX_BLOCK_SIZE:
        raise _DamagedError(f"a length of {size} bytes; the file is damaged here")
    return size


def _other_link_type(link_type: int) -> str:
    return f"packets of link type {link_type}; expected {LINK_TYPE} (CAN_SOCKETCAN), as of interface can0"


class _Writer:
    """A file that is being written."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file

    def close(self) -> None:
        """Close the file."""
        self._file.close()


class PcapWriter(_Writer):
    """Writes frames as PCAP with nanoseconds."""

    def __init__(self, file: BinaryIO) -> None:
        """Begin a file."""
        super().__init__(file)
        file.write(struct.pack("<IHHiIII", 0xA1B23C4D, 2, 4, 0, 0, _SNAP_LENGTH, LINK_TYPE))

    def write_frame(self, frame: Frame) -> None:
        """Write a frame; the name of its interface and its direction are left out."""
        whole, rest = divmod(nanoseconds(frame.time), NANOSECOND)
        packet = packet_of(frame)
        self._file.write(struct.pack("<IIII", whole, rest, len(packet), len(packet)) + packet)


class PcapngWriter(_Writer):
    """Writes frames as PCAPNG with nanoseconds, interfaces and directions."""

    def __init__(self, file: BinaryIO) -> None:
        """Begin a file."""
        super().__init__(file)
        self._interfaces: dict[str, int] = {}
        self._block(_SECTION, struct.pack("<IHHq", _ORDER_MAGIC, 1, 0, -1))

    def write_frame(self, frame: Frame) -> None:
        """Write a frame, and before the first of an interface what the interface is."""
        if frame.channel not in self._interfaces:
            self._interfaces[frame.channel] = len(self._interfaces)
            options = _option(_IF_NAME, frame.channel.encode()) + _option(_IF_RESOLUTION, b"\x09")
            self._block(_INTERFACE, struct.pack("<HHI", LINK_TYPE, 0, _SNAP_LENGTH) + options + bytes(4))
        packet, stamp = packet_of(frame), nanoseconds(frame.time)
        body = struct.pack(
            "<IIIII",
            self._interfaces[frame.channel],
            stamp >> 32,
            stamp & 0xFFFFFFFF,
            len(packet),
            len(packet),
        )
        body += packet + bytes(-len(packet) % 4)
        direction = frame.flags & (RECEIVED | SENT)
        if direction:
            flags = _OUTBOUND if direction & SENT else _INBOUND
            body += _option(_EPB_FLAGS, struct.pack("<I", flags)) + bytes(4)
        self._block(_ENHANCED, body)

    def _block(self, kind: int, body: bytes) -> None:
        size = struct.pack("<I", len(body) + 12)
        self._file.write(struct.pack("<I", kind) + size + body + size)


def _option(code: int, value: bytes) -> bytes:
    return struct.pack("<HH", code, len(value)) + value + bytes(-len(value) % 4)
