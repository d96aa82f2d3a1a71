"""The socketcand words: they round-trip with python-can's own client, and no bytes break the parser."""

from contextlib import suppress
from itertools import pairwise

import can
import pytest
from can.interfaces.socketcand.socketcand import (
    convert_ascii_message_to_can_message,
    convert_can_message_to_ascii_message,
)
from hypothesis import given
from hypothesis import strategies as st

from omnimate.vcan_sim.errors import ProtocolError
from omnimate.vcan_sim.socketcand import CommandReader, format_frame, parse_send

frames = st.booleans().flatmap(
    lambda extended: st.builds(
        can.Message,
        timestamp=st.floats(0.0, 4e9),
        arbitration_id=st.integers(0, 0x1FFFFFFF if extended else 0x7FF),
        data=st.binary(max_size=8),
        is_extended_id=st.just(extended),
    )
)


def sent_by_python_can(frame):
    return convert_can_message_to_ascii_message(frame).encode()


@given(frames)
def test_what_python_can_sends_is_parsed(frame):
    (command,) = CommandReader().feed(sent_by_python_can(frame))
    assert parse_send(command).equals(frame, timestamp_delta=None)


@given(frames)
def test_what_is_formatted_python_can_parses(frame):
    message = convert_ascii_message_to_can_message(format_frame(frame).decode())
    assert message.equals(frame, timestamp_delta=1e-6)


@given(st.lists(frames, max_size=10), st.lists(st.integers(0, 400), max_size=10))
def test_commands_may_be_cut_anywhere(sent, cuts):
    stream = b"".join(sent_by_python_can(frame) for frame in sent)
    bounds = [0, *sorted(min(cut, len(stream)) for cut in cuts), len(stream)]
    reader = CommandReader()
    commands = []
    for start, end in pairwise(bounds):
        commands += reader.feed(stream[start:end])
    for command, frame in zip(commands, sent, strict=True):
        assert parse_send(command).equals(frame, timestamp_delta=None)


@given(st.lists(st.binary(max_size=60), max_size=20))
def test_no_bytes_break_the_reader_otherwise_than_by_its_own_error(parts):
    reader = CommandReader()
    with suppress(ProtocolError):
        for part in parts:
            for command in reader.feed(part):
                parse_send(command)


def test_a_frame_without_data_keeps_both_spaces():
    assert format_frame(can.Message(1.5, 0x080, is_extended_id=False)) == b"< frame 080 1.500000  >"


def test_extended_identifiers_have_eight_digits():
    assert format_frame(can.Message(0.0, 0x81, data=b"\x0a")) == b"< frame 00000081 0.000000 0A >"


def test_a_remote_frame_of_a_stock_client_is_told_apart():
    message = can.Message(arbitration_id=0x701, is_remote_frame=True, dlc=1, is_extended_id=False)
    (command,) = CommandReader().feed(convert_can_message_to_ascii_message(message).encode())
    assert parse_send(command) is None


@pytest.mark.parametrize(
    "stream", [b"send 123 0 >", b"< send 123 0  > x >", b"<" + b" " * 600, b"<" + b"a" * 600 + b">"]
)
def test_a_stream_that_is_no_commands_is_refused(stream):
    with pytest.raises(ProtocolError):
        CommandReader().feed(stream)


@pytest.mark.parametrize(
    "command",
    [
        *("send 123", "send 1234 1 00", "send 0x1 1 11", "send 123 -1 11"),
        *("send 123 0 11", "send 123 1 11 22", "send 123 1 111"),
    ],
)
def test_a_malformed_send_is_refused(command):
    """Those whose message is held word for word are in `broken_sends.toml`."""
    with pytest.raises(ProtocolError):
        parse_send(command)
