"""DBC files: those of any tool read, and written for any messages or for those of a vehicle.

Every channel of a vehicle is a signal in radians or metres.
"""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple, cast

from cantools.database import load_string
from cantools.database.errors import Error as DatabaseError

from omnimate.files.logs.canopen_words import NMT_STATES, SYNC_ID
from omnimate.files.logs.decoding import vehicle_signals
from omnimate.files.logs.signals import EXTENDED_KEY, FLOAT_WIDTHS, Signal
from omnimate.vehicle.errors import LogError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from cantools.database.can import Database, Message

    from omnimate.vehicle.parameters import VehicleParameters

MAX_BYTES = 8  # of a message of classical CAN; those of CAN FD with more are left out
_MAX_NAME_LENGTH = 32  # characters of a DBC name
_HOST = "host"


class DbcMessage(NamedTuple):
    """A message of a DBC file.

    `EXTENDED_KEY` is added to the identifier in the key for 29 bits; the length is in bytes; names of signals
    are identifiers of C, and comments are by them.
    """

    key: int
    name: str
    length: int
    sender: str
    receiver: str
    signals: tuple[Signal, ...] = ()
    comments: Mapping[str, str] = {}


def format_dbc(nodes: Sequence[str], messages: Sequence[DbcMessage], comment: str = "") -> str:
    """Return the text of a DBC file.

    `nodes` are the names of those who send and receive, `comment` is on the whole network.
    """
    lines = ['VERSION ""', "", "NS_ :", "", "BS_:", "", " ".join(["BU_:", *nodes]), ""]
    for message in messages:
        lines += [f"BO_ {message.key} {message.name}: {message.length} {message.sender}"]
        lines += [*(_signal_line(signal, message) for signal in message.signals), ""]
    lines += [f'CM_ "{_quoted(comment)}";'] if comment else []
    for message in messages:
        for name, words in message.comments.items():
            lines.append(f'CM_ SG_ {message.key} {name} "{_quoted(words)}";')
        for signal in message.signals:
            lines += _value_lines(message, signal)
    return "\n".join([*lines, ""])


def dbc_of_vehicle(vehicle: VehicleParameters) -> str:
    """Return the text of a DBC file: SYNC, PDOs, and heartbeat and EMCY of every node."""
    messages = [DbcMessage(SYNC_ID, "SYNC", 0, _HOST, _HOST), *_pdos(vehicle)]
    for node in vehicle.nodes:
        emcy = (Signal("error_code", 0, 16), Signal("error_register", 16, 8))
        messages.append(DbcMessage(0x80 + node, f"EMCY_{node}", 8, node_name(node), _HOST, emcy))
        messages.append(heartbeat_message(node, _HOST))
    return format_dbc([_HOST, *map(node_name, vehicle.nodes)], messages, vehicle.name)


def node_name(node: int) -> str:
    """Return the name of a node."""
    return f"node_{node}"


def heartbeat_message(node: int, receiver: str) -> DbcMessage:
    """Return the message of a node's heartbeat, which names the NMT states."""
    state = Signal("state", 0, 7, choices=NMT_STATES)
    return DbcMessage(0x700 + node, f"heartbeat_{node}", 1, node_name(node), receiver, (state,))


def _pdos(vehicle: VehicleParameters) -> Iterator[DbcMessage]:
    """Yield the TPDOs of encoders and the RPDOs of drives."""
    senders = {encoder.cob_id: encoder.node for encoder in reversed(vehicle.encoders)}
    receivers = {drive.cob_id: drive.node for drive in reversed(vehicle.drives)}
    for cob_id, carried in vehicle_signals(vehicle).items():
        signals = tuple(replace(signal, name=re.sub(r"\W", "_", signal.name)) for signal in carried)
        is_sent = cob_id in senders
        ends = (node_name(senders[cob_id]), _HOST) if is_sent else (_HOST, node_name(receivers[cob_id]))
        name = "_".join(signal.name for signal in signals)
        name = name if len(name) <= _MAX_NAME_LENGTH else f"{'T' if is_sent else 'R'}PDO_{cob_id:03X}"
        yield DbcMessage(cob_id, name, max(signal.length for signal in signals), *ends, signals)


def _signal_line(signal: Signal, message: DbcMessage) -> str:
    switches = {other.switch[0].name for other in message.signals if other.switch is not None}
    switch = " M" if signal.name in switches else "" if signal.switch is None else f" m{signal.switch[1][0]}"
    order, sign = "0" if signal.is_big_endian else "1", "-" if signal.signed or signal.is_float else "+"
    return (
        f" SG_ {signal.name}{switch} : {signal.start_bit}|{signal.bits}@{order}{sign} "
        f'({signal.factor!r},{signal.offset!r}) [0|0] "{signal.unit}" {message.receiver}'
    )


def _value_lines(message: DbcMessage, signal: Signal) -> Iterator[str]:
    if signal.choices:
        words = " ".join(f'{code} "{_quoted(name)}"' for code, name in sorted(signal.choices.items()))
        yield f"VAL_ {message.key} {signal.name} {words} ;"
    if signal.is_float:
        yield f"SIG_VALTYPE_ {message.key} {signal.name} : {signal.bits // 32};"


def _quoted(text: str) -> str:
    return text.replace("\\", "/").replace('"', "'")


def read_dbc(path: Path) -> dict[int, tuple[Signal, ...]]:
    """Return the signals of a DBC file by identifier, to which `EXTENDED_KEY` is added for 29 bits.

    Messages of more than 8 bytes, of CAN FD, are left out.

    Raises:
        LogError: The file cannot be read, is no DBC file, or holds no message.
    """
    try:
        text = _without_strays(_decode(path.read_bytes()))
        messages = cast("Database", load_string(text, "dbc", strict=False)).messages
    except OSError as error:
        raise LogError(path, None, f"cannot be read: {error.strerror or error}") from error
    except DatabaseError as error:
        raise LogError(path, None, f"cannot be read as a DBC file: {error}") from error
    signals = {
        message.frame_id | (EXTENDED_KEY if message.is_extended_frame else 0): _signals(path, message)
        for message in messages
        if message.length <= MAX_BYTES
    }
    if not signals:
        expected = "expected lines such as `BO_ 385 name: 8 node`"
        raise LogError(path, None, f"no message of up to 8 bytes in the file; {expected}")
    return {key: carried for key, carried in signals.items() if carried}


def _decode(content: bytes) -> str:
    """Return the text of a DBC file; no other text of Windows-1252 than ASCII is likely to be UTF-8, too."""
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("cp1252", "replace")


def _without_strays(text: str) -> str:
    """Return the text of a DBC file without lines on what is not in it, as exports of a part leave them.

    cantools refuses a file for words and types of absent signals, and for undefined attributes.
    """
    message, known, kept = "", set[tuple[str, str]](), list[str]()
    for line in text.splitlines():
        attribute = "attribute", "".join(line.split('"')[1:2])
        match line.split(maxsplit=3):
            case ["BO_", message, *_]:
                pass
            case ["SG_", signal, *_]:
                known.add((message, signal))
            case ["BA_DEF_", *_]:
                known.add(attribute)
            case ["BA_", *_] if attribute not in known:
                continue
            case ["VAL_" | "SIG_VALTYPE_", of, signal, *_] if of.isdigit() and line.rstrip().endswith(";"):
                if (of, signal.rstrip(":")) not in known:
                    continue
        kept.append(line)
    return "\n".join([*kept, ""])


def _signals(path: Path, message: Message) -> tuple[Signal, ...]:
    """Return the signals of a message, each with its multiplexor if it has one."""
    described = {signal.name: signal for signal in message.signals}

    def read(name: str, switched: tuple[str, ...] = ()) -> Signal:
        """Return a signal; those that depend on it are `switched`, on none of which it can depend."""
        found, switched = described[name], (*switched, name)
        on, raw_values = found.multiplexer_signal, found.multiplexer_ids
        depends = on in described and on not in switched and bool(raw_values)
        signal = Signal(
            name,
            found.start,
            found.length,
            found.is_signed,
            float(found.scale),
            float(found.offset),
            found.unit or "",
            is_big_endian=found.byte_order == "big_endian",
            is_float=found.is_float,
            choices={code: str(words) for code, words in (found.choices or {}).items()},
            switch=(read(str(on), switched), tuple(raw_values or ())) if depends else None,
        )
        widths = FLOAT_WIDTHS if signal.is_float else range(1, 65)
        if signal.bits not in widths or signal.shift < 0 or signal.length > MAX_BYTES:
            number = f"{name} of {message.name} with {signal.bits} bits from bit {signal.start_bit}"
            raise LogError(path, None, f"{number} is no float, or does not fit {MAX_BYTES} bytes")
        return signal

    return tuple(map(read, described))
