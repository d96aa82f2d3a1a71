"""PCAP and PCAPNG: other readers see every frame as it was; damaged captures are read as far as they go."""

import io
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scapy.layers.can import CAN, CANFD
from scapy.utils import PcapNgReader, PcapReader

from omnimate.files.logs.formats.candump_blocks import SkippedLine
from omnimate.files.logs.formats.capture import (
    PcapngWriter,
    PcapWriter,
    capture_format_of,
    frame_of_packet,
    packet_of,
    read_capture,
)
from omnimate.files.logs.frames import (
    BRS,
    ERROR,
    ESI,
    EXTENDED,
    FD,
    RECEIVED,
    REMOTE,
    SENT,
    Frame,
    nanoseconds,
)
from tests.files.logs.any_frames import any_frames, logs

WRITERS = {"pcap": PcapWriter, "pcapng": PcapngWriter}


def capture(rows, form="pcap"):
    """The bytes of a capture."""
    file = io.BytesIO()
    writer = WRITERS[form](file)
    for row in rows:
        writer.write_frame(row)
    return file.getvalue()


@given(logs(directions=(0, SENT, RECEIVED)))
def test_pcapng_gives_every_frame_back_with_its_interface_and_direction(rows):
    assert list(read_capture(io.BytesIO(capture(rows, "pcapng")))) == rows


@given(logs(channels=("can0",), directions=(0,)))
def test_pcap_gives_every_frame_of_one_interface_back(rows):
    assert list(read_capture(io.BytesIO(capture(rows)))) == rows


NAMES = {ERROR: "error", REMOTE: "remote_transmission_request", EXTENDED: "extended"}
FD_NAMES = {BRS: "bit_rate_switch", ESI: "error_state_indicator", FD: "fd_frame"}


@given(logs(channels=("can0",)), st.sampled_from(["pcap", "pcapng"]))
def test_scapy_reads_the_same_identifiers_flags_data_and_nanoseconds(rows, form):
    reader = {"pcap": PcapReader, "pcapng": PcapNgReader}[form]
    packets = list(reader(io.BytesIO(capture(rows, form))))
    for packet, row in zip(packets, rows, strict=True):
        assert isinstance(packet, CANFD if row.flags & FD else CAN)
        assert (packet.identifier, packet.length, packet.data) == (row.can_id, row.length, row.data)
        assert words(packet.flags) == {name for bit, name in NAMES.items() if row.flags & bit}
        if row.flags & FD:
            assert words(packet.fd_flags) == {name for bit, name in FD_NAMES.items() if row.flags & bit}
        assert int(packet.time * 10**9) == nanoseconds(row.time)


def words(flags):
    """The names that scapy gives to the bits that are set."""
    return {word for word in str(flags).split("+") if word}


@pytest.mark.parametrize(
    ("flags", "bits", "fd"),
    [
        (0, 0x123, 0),
        (EXTENDED, 0x80000123, 0),
        (REMOTE, 0x40000123, 0),
        (ERROR, 0x20000123, 0),
        (FD, 0x123, 4),
        (FD | BRS, 0x123, 5),
        (FD | ESI | EXTENDED, 0x80000123, 6),
    ],
)
def test_a_packet_has_the_bits_of_linux_can_h_in_network_order(flags, bits, fd):
    data = b"" if flags & REMOTE else b"\1\2\3"
    packet = packet_of(Frame(1.0, 0x123, data, flags, 3))
    assert packet == struct.pack(">IBBxx", bits, 3, fd) + data


def test_a_capture_of_the_other_byte_order_with_microseconds_is_read():
    packet = packet_of(Frame(0.0, 0x181, b"AB"))
    content = struct.pack(">IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 227)
    content += struct.pack(">IIII", 1700000000, 250, len(packet), len(packet)) + packet
    assert capture_format_of(content) == "pcap"
    assert list(read_capture(io.BytesIO(content))) == [Frame(1700000000.00025, 0x181, b"AB", 0, 2)]


@pytest.mark.parametrize("order", ["<", ">"])
def test_a_capture_on_all_interfaces_has_identifiers_in_the_order_of_its_host(order):
    def cooked(kind, protocol, bits):
        return (
            struct.pack(">HHH8xH", kind, 280, 0, protocol) + struct.pack(order + "IBBxx", bits, 2, 0) + b"AB"
        )

    content = struct.pack(order + "IHHiIII", 0xA1B23C4D, 2, 4, 0, 0, 65535, 113)
    for packet in (cooked(1, 0x000C, 0x181), cooked(4, 0x000C, 0x80012345), cooked(0, 0x0800, 0)):
        content += struct.pack(order + "IIII", 1, 0, len(packet), len(packet)) + packet
    first, second, other = read_capture(io.BytesIO(content))
    assert first == Frame(1.0, 0x181, b"AB", 0, 2)
    assert second == Frame(1.0, 0x12345, b"AB", EXTENDED | SENT, 2)
    assert "protocol 0800h, which is not CAN" in other.reason


def test_a_padded_packet_of_72_bytes_is_can_fd_even_without_its_bit():
    packet = struct.pack(">IBBxx", 0x181, 2, 0) + b"AB" + bytes(62)
    assert frame_of_packet(packet, 1.0) == Frame(1.0, 0x181, b"AB", FD, 2)


def test_a_capture_of_another_link_type_says_which_and_what_was_expected():
    content = struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 1)
    (line,) = read_capture(io.BytesIO(content))
    assert "link type 1; expected 227 (CAN_SOCKETCAN)" in line.reason
    assert line.is_end


@given(any_frames(channels=("can0",), directions=(0,)), st.sampled_from(["pcap", "pcapng"]), st.data())
def test_a_capture_that_was_cut_off_gives_the_frames_before_and_says_so(row, form, data):
    whole = capture([row, row], form)
    one = len(capture([row], form))
    entries = list(read_capture(io.BytesIO(whole[: data.draw(st.integers(one + 1, len(whole) - 1))])))
    assert entries[0] == row
    assert entries[-1].is_end


@given(st.binary(max_size=200), st.sampled_from(["pcap", "pcapng"]))
def test_no_damage_breaks_the_reader(garbage, form):
    whole = capture([Frame(1.0, 0x181, b"AB")], form)
    for entry in read_capture(io.BytesIO(whole + garbage)):
        assert isinstance(entry, Frame | SkippedLine)


def test_fd_frames_are_left_out_where_only_classical_can_is_asked_for():
    (line,) = read_capture(io.BytesIO(capture([Frame(1.0, 0x181, bytes(12), FD)])), fd=False)
    assert "CAN FD" in line.reason
