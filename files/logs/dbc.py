"""DBC files: any messages, and those of a vehicle with every channel as a signal in radians or metres."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from omnimate.files.logs.canopen_words import NMT_STATES, SYNC_ID
from omnimate.files.logs.decoding import vehicle_signals
from omnimate.files.logs.signals import Signal

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from omnimate.vehicle.parameters import VehicleParameters

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
    switch = " M" if signal.name in switches else "" if signal.switch is None else f" m{signal.switch[1]}"
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
