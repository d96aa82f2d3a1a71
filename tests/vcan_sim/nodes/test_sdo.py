"""The SDO server: transfers, aborts, and frames that no client should send."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnimate.vcan_sim.errors import SdoAbort
from omnimate.vcan_sim.nodes.abort import Abort
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

    return SdoServer(read, write), values


def upload(server, index, sub=0):
    """Return what a client uploads, by segments where the server wants it."""
    answer = server.answer(bytes([0x40, index & 0xFF, index >> 8, sub]) + bytes(4))
    if answer[0] & 0x02:
        return answer[4 : 8 - (answer[0] >> 2 & 3)]
    size, data, toggle = int.from_bytes(answer[4:], "little"), b"", 0
    while True:
        answer = server.answer(bytes([0x60 | toggle]) + bytes(7))
        assert answer[0] & 0x10 == toggle
        data += answer[1 : 8 - (answer[0] >> 1 & 7)]
        toggle ^= 0x10
        if answer[0] & 0x01:
            assert len(data) == size
            return data


def download_in_segments(server, index, data):
    server.answer(bytes([0x21, index & 0xFF, index >> 8, 0]) + len(data).to_bytes(4, "little"))
    toggle = 0
    for start in range(0, len(data), 7):
        part, last = data[start : start + 7], start + 7 >= len(data)
        answer = server.answer(bytes([toggle | (7 - len(part)) << 1 | last]) + part.ljust(7, b"\0"))
        assert answer[0] == 0x20 | toggle
        toggle ^= 0x10


@given(st.binary(min_size=1, max_size=60))
def test_what_is_downloaded_in_segments_is_uploaded_again(data):
    server, _ = store()
    download_in_segments(server, 0x2000, data)
    assert upload(server, 0x2000) == data


def test_an_expedited_download_without_a_size_carries_four_bytes():
    server, values = store()
    assert server.answer(b"\x22\x00\x20\x00\x09\x08\x07\x06")[0] == 0x60
    assert values[0x2000, 0] == b"\x09\x08\x07\x06"


def test_a_repeated_toggle_bit_ends_the_transfer():
    server, _ = store()
    server.answer(b"\x40\x08\x10\x00" + bytes(4))
    assert server.answer(b"\x70" + bytes(7)) == b"\x80\x08\x10\x00" + Abort.TOGGLE.to_bytes(4, "little")
    assert server.answer(b"\x60" + bytes(7))[4:] == Abort.COMMAND.to_bytes(4, "little")


def test_a_segment_without_a_transfer_is_refused():
    server, _ = store()
    for request in (b"\x00" + bytes(7), b"\x60" + bytes(7)):
        assert server.answer(request)[4:] == Abort.COMMAND.to_bytes(4, "little")


def test_block_transfers_are_refused_so_that_a_client_falls_back():
    server, _ = store()
    assert server.answer(b"\xa0\x08\x10\x00" + bytes(4))[4:] == Abort.COMMAND.to_bytes(4, "little")


def test_an_abort_by_the_client_is_not_answered_and_ends_the_transfer():
    server, _ = store()
    server.answer(b"\x40\x08\x10\x00" + bytes(4))
    assert server.answer(b"\x80\x08\x10\x00" + bytes(4)) is None
    assert server.answer(b"\x60" + bytes(7))[0] == 0x80


def test_a_download_without_end_is_refused():
    server, _ = store()
    server.answer(b"\x20\x00\x20\x00" + bytes(4))
    answers = [server.answer(bytes([0x10 * (number % 2)]) + bytes(7)) for number in range(12)]
    assert Abort.LENGTH.to_bytes(4, "little") in {answer[4:] for answer in answers}


@given(st.lists(st.binary(max_size=9), max_size=30))
def test_whatever_a_client_sends_the_answer_is_a_whole_frame_or_none(requests):
    server, _ = store()
    for request in requests:
        answer = server.answer(request)
        assert answer is None or len(answer) == 8


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


def test_a_stopped_node_does_not_answer(bench):
    bench.nmt(0x02, 1)
    assert bench.request(1, b"\x40\x00\x10\x00" + bytes(4)) is None


def test_every_object_of_every_device_can_be_read_or_says_why_not(bench):
    for node, device in bench.simulated.devices.items():
        for index, sub in device.store._variables:
            answer = bench.request(node, bytes([0x40, index & 0xFF, index >> 8, sub]) + bytes(4))
            is_empty_history = index == 0x1003 and sub
            assert (answer[0] == 0x80) == bool(is_empty_history), (node, hex(index), sub)
