"""The SDO server: transfers, aborts, and frames that no client should send."""

from binascii import crc_hqx

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.vcan_sim.errors import Abort, SdoAbort
from omnimate.vcan_sim.nodes.sdo import SdoServer

NAME = b"a name of more than seven bytes"


def store():
    """Return a server with a name at 1008h, 4 bytes at 2000h, and its dictionary."""
    values = {(0x1008, 0): NAME, (0x2000, 0): b"\x01\x02\x03\x04"}

    def read(index, sub):
        if (index, sub) not in values:
            raise SdoAbort(Abort.NO_OBJECT)
        return values[index, sub]

    def write(index, sub, data):
        values[index, sub] = data

    return SdoServer(read, write, lambda index, sub: len(read(index, sub))), values


def answer_of(server, request):
    """Return the one answer to a request, None where there is none."""
    answers = server.answers(request)
    assert len(answers) <= 1
    return answers[0] if answers else None


def upload(server, index, sub=0):
    """Return what a client uploads, by segments where the server wants it."""
    answer = answer_of(server, bytes([0x40, index & 0xFF, index >> 8, sub]) + bytes(4))
    if answer[0] & 0x02:
        return answer[4 : 8 - (answer[0] >> 2 & 3)]
    size, data, toggle = int.from_bytes(answer[4:], "little"), b"", 0
    while True:
        answer = answer_of(server, bytes([0x60 | toggle]) + bytes(7))
        assert answer[0] & 0x10 == toggle
        data += answer[1 : 8 - (answer[0] >> 1 & 7)]
        toggle ^= 0x10
        if answer[0] & 0x01:
            assert len(data) == size
            return data


def download_in_segments(server, index, data):
    answer_of(server, bytes([0x21, index & 0xFF, index >> 8, 0]) + len(data).to_bytes(4, "little"))
    toggle = 0
    for start in range(0, len(data), 7):
        part, last = data[start : start + 7], start + 7 >= len(data)
        answer = answer_of(server, bytes([toggle | (7 - len(part)) << 1 | last]) + part.ljust(7, b"\0"))
        assert answer[0] == 0x20 | toggle
        toggle ^= 0x10


@given(st.binary(min_size=1, max_size=60))
def test_what_is_downloaded_in_segments_is_uploaded_again(data):
    server, _ = store()
    download_in_segments(server, 0x2000, data)
    assert upload(server, 0x2000) == data


def test_an_expedited_download_without_a_size_carries_four_bytes():
    server, values = store()
    assert answer_of(server, b"\x22\x00\x20\x00\x09\x08\x07\x06")[0] == 0x60
    assert values[0x2000, 0] == b"\x09\x08\x07\x06"


def test_a_repeated_toggle_bit_ends_the_transfer():
    server, _ = store()
    answer_of(server, b"\x40\x08\x10\x00" + bytes(4))
    assert answer_of(server, b"\x70" + bytes(7)) == b"\x80\x08\x10\x00" + Abort.TOGGLE.to_bytes(4, "little")
    assert answer_of(server, b"\x60" + bytes(7))[4:] == Abort.COMMAND.to_bytes(4, "little")


def test_a_segment_without_a_transfer_is_refused():
    server, _ = store()
    for request in (b"\x00" + bytes(7), b"\x60" + bytes(7)):
        assert answer_of(server, request)[4:] == Abort.COMMAND.to_bytes(4, "little")


def upload_block(server, index, block_size, lost=()):
    """Return what a block upload gives; of the segments, those with the numbers `lost` do not arrive once."""
    answer = answer_of(server, bytes([0xA4, index & 0xFF, index >> 8, 0, block_size]) + bytes(3))
    assert answer[0] == 0xC6
    lost, data, segments = set(lost), b"", server.answers(b"\xa3" + bytes(7))
    while True:
        received = 0
        for segment in segments:
            if segment[0] & 0x7F in lost:
                lost.discard(segment[0] & 0x7F)
                break
            received += 1
            data += segment[1:]
        segments = server.answers(bytes([0xA2, received, block_size]) + bytes(5))
        if segments[0][0] & 0xE3 == 0xC1:
            break
    assert server.answers(b"\xa1" + bytes(7)) == ()
    data = data[: len(data) - (segments[0][0] >> 2 & 7)]
    assert int.from_bytes(segments[0][1:3], "little") == crc_hqx(data, 0)
    assert int.from_bytes(answer[4:], "little") == len(data)
    return data


def download_block(server, index, data, crc_error=0, announced=None):
    """Return the last answer of a block download."""
    size = len(data) if announced is None else announced
    begin = answer_of(server, bytes([0xC6, index & 0xFF, index >> 8, 0]) + size.to_bytes(4, "little"))
    assert begin[0] == 0xA4
    parts = [data[start : start + 7] for start in range(0, len(data), 7)]
    for number, part in enumerate(parts, start=1):
        last = 0x80 if number == len(parts) else 0
        answer = answer_of(server, bytes([number | last]) + part.ljust(7, b"\0"))
    assert answer[:2] == bytes([0xA2, len(parts)])
    crc = crc_hqx(data, 0) ^ crc_error
    return answer_of(server, bytes([0xC1 | (-len(data) % 7) << 2]) + crc.to_bytes(2, "little") + bytes(5))


@given(
    data=st.binary(min_size=1, max_size=60), block_size=st.integers(1, 127), lost=st.sets(st.integers(1, 9))
)
def test_what_is_downloaded_in_a_block_is_uploaded_in_blocks_with_segments_lost(data, block_size, lost):
    server, _ = store()
    assert download_block(server, 0x2000, data)[0] == 0xA1
    assert upload_block(server, 0x2000, block_size, lost) == data


@given(data=st.binary(min_size=1, max_size=60), crc_error=st.integers(1, 0xFFFF))
def test_a_block_with_a_wrong_crc_is_refused(data, crc_error):
    server, values = store()
    assert download_block(server, 0x2000, data, crc_error)[4:] == Abort.CRC.to_bytes(4, "little")
    assert values[0x2000, 0] == b"\1\2\3\4"


def test_a_block_or_segments_of_another_length_than_announced_are_refused():
    server, values = store()
    assert download_block(server, 0x2000, b"12345", announced=6)[4:] == Abort.LENGTH.to_bytes(4, "little")
    answer_of(server, b"\x21\x00\x20\x00\x03\0\0\0")
    assert answer_of(server, b"\x0b12" + bytes(5))[4:] == Abort.LENGTH.to_bytes(4, "little")
    assert values[0x2000, 0] == b"\1\2\3\4"


def test_a_block_of_an_object_that_fits_the_clients_threshold_is_a_plain_upload():
    server, _ = store()
    assert answer_of(server, b"\xa4\x00\x20\x00\x7f\x04\0\0") == b"\x43\x00\x20\x00\1\2\3\4"


def test_a_download_without_end_is_refused():
    server, _ = store()
    answer_of(server, b"\x20\x00\x20\x00" + bytes(4))
    answers = [answer_of(server, bytes([0x10 * (number % 2)]) + bytes(7)) for number in range(12)]
    assert Abort.LENGTH.to_bytes(4, "little") in {answer[4:] for answer in answers}


@given(st.lists(st.binary(max_size=9), max_size=30))
def test_whatever_a_client_sends_its_answers_are_whole_frames(requests):
    server, _ = store()
    for request in requests:
        assert all(len(answer) == 8 for answer in server.answers(request))


@pytest.mark.parametrize(
    ("index", "sub", "value", "size", "code"),
    [
        (0x1000, 0, 1, 4, 0x06010002),
        (0x6004, 0, 1, 4, 0x06010002),
        (0x2100, 0, 1, 4, 0x06020000),
        (0x1018, 9, 1, 4, 0x06090011),
        (0x1017, 0, 1, 4, 0x06070010),
        (0x6000, 0, 0xFF, 2, 0x06090030),
        (0x1005, 0, 0x81, 4, 0x06090030),
        (0x1003, 0, 1, 1, 0x06090030),
    ],
)
def test_a_write_that_cannot_be_is_answered_with_its_abort_code(bench, index, sub, value, size, code):
    assert bench.aborts(1, index, sub, value, size) == code


def test_every_object_of_every_device_can_be_read_or_says_why_not(bench):
    for node, device in bench.simulated.devices.items():
        for index, sub in device.objects.variables:
            answer = bench.request(node, bytes([0x40, index & 0xFF, index >> 8, sub]) + bytes(4))
            is_empty_history = index == 0x1003 and sub
            assert (answer[0] == 0x80) == bool(is_empty_history), (node, hex(index), sub)
