"""Messages of the socketcand protocol in raw mode, for python-can's `socketcand` interface.

The protocol has neither remote frames nor CAN FD. A frame without data has the space before the data, too:
`< frame 080 1700000000.000000  >`; otherwise clients do not find the end of the time.
"""

from __future__ import annotations

import re

import can

from omnimate.vcan_sim.errors import ProtocolError

_LONGEST_COMMAND = 512  # [byte]; the longest that is sent in practice has 48
_STANDARD_DIGITS, _EXTENDED_DIGITS = 3, 8
_IDENTIFIER = re.compile(r"[0-9A-Fa-f]{3}|[0-9A-Fa-f]{8}")
_BYTE = re.compile(r"[0-9A-Fa-f]{1,2}")
_LENGTH = re.compile(r"[0-8]")


class CommandReader:
    """Splits a client's stream of bytes into commands."""

    def __init__(self) -> None:
        self._rest = b""

    def feed(self, data: bytes) -> list[str]:
        """Return the commands that `data` completes, without their brackets.

        Raises ProtocolError for text between the commands, or a command that does not end.
        """
        *complete, self._rest = (self._rest + data).split(b">")
        if len(self._rest) > _LONGEST_COMMAND:
            raise ProtocolError(_text(self._rest), "the command has no end")
        return [_inner(part) for part in complete]


def _text(data: bytes) -> str:
    return data.decode("ascii", errors="replace")


def _inner(part: bytes) -> str:
    """Return the text between the brackets, without blanks at both ends."""
    text = _text(part).lstrip()
    if not text.startswith("<") or len(text) > _LONGEST_COMMAND:
        raise ProtocolError(text, "expected `< command >`")
    return text[1:].strip()


def parse_send(command: str) -> can.Message | None:
    """Return the message of a `send 123 2 11 22`; None for a remote frame, which has a length but no data.

    Raises ProtocolError for any other text.
    """
    words = command.split()
    if len(words) < 3 or words[0] != "send":
        raise ProtocolError(command, "expected `send id length bytes`")
    _, identifier, length, *data = words
    if not (_IDENTIFIER.fullmatch(identifier) and _LENGTH.fullmatch(length)):
        raise ProtocolError(command, "expected an identifier of 3 or 8 digits and a length of 0 to 8")
    if int(length) and not data:
        return None
    if len(data) != int(length) or not all(_BYTE.fullmatch(byte) for byte in data):
        raise ProtocolError(command, f"expected {length} bytes in hexadecimal digits")
    return _frame(command, identifier, bytes(int(byte, 16) for byte in data))


def _frame(command: str, identifier: str, data: bytes) -> can.Message:
    can_id, extended = int(identifier, 16), len(identifier) == _EXTENDED_DIGITS
    if can_id > (0x1FFF_FFFF if extended else 0x7FF):
        raise ProtocolError(command, "the identifier has more than 11 or 29 bits")
    return can.Message(arbitration_id=can_id, data=data, is_extended_id=extended)


def format_frame(message: can.Message) -> bytes:
    """Return a data frame as the clients receive it; its time stamp is in seconds since 1970."""
    digits = _EXTENDED_DIGITS if message.is_extended_id else _STANDARD_DIGITS
    identifier, data = f"{message.arbitration_id:0{digits}X}", message.data.hex().upper()
    return f"< frame {identifier} {message.timestamp:.6f} {data} >".encode("ascii")
