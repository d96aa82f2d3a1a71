"""A vehicle as a DBC file: every PDO a message, every channel a signal in radians or metres."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.files.logs.canopen_words import NMT_STATES, SYNC_ID
from omnimate.files.logs.pdo_units import drive_conversion, encoder_conversion

if TYPE_CHECKING:
    from collections.abc import Iterable

    from omnimate.files.logs.pdo_units import Conversion
    from omnimate.vehicle.parameters import VehicleParameters

_LONGEST_NAME = 32  # characters of a DBC name
_READER = "host"


def format_dbc(vehicle: VehicleParameters) -> str:
    """Return the text of a DBC file: SYNC, PDOs, and heartbeat and EMCY of every node."""
    nodes = sorted({owner.node for owner in vehicle.encoders} | {drive.node for drive in vehicle.drives})
    head = [*head_lines([_READER, *map(node_name, nodes)]), f"BO_ {SYNC_ID} SYNC: 0 {_READER}", ""]
    blocks = [*_encoder_messages(vehicle), *_drive_messages(vehicle), *map(_node_messages, nodes)]
    name = vehicle.name.replace("\\", "/").replace('"', "'")
    return "\n".join([*head, *blocks, f'CM_ "{name}";', *map(state_names, nodes), ""])


def head_lines(units: Iterable[str]) -> list[str]:
    """Return the lines with which a DBC file begins, an empty line last.

    Args:
        units: Names of those who send and receive.
    """
    return ['VERSION ""', "", "NS_ :", "", "BS_:", "", " ".join(["BU_:", *units]), ""]


def node_name(node: int) -> str:
    """Return the name of a node."""
    return f"node_{node}"


def heartbeat_message(node: int, reader: str) -> str:
    """Return the message of a node's heartbeat, an empty line last."""
    return (
        f"BO_ {0x700 + node} heartbeat_{node}: 1 {node_name(node)}\n"
        f' SG_ state : 0|7@1+ (1,0) [0|0] "" {reader}\n'
    )


def state_names(node: int) -> str:
    """Return the line that names the NMT states in a node's heartbeat."""
    states = " ".join(f'{code} "{name}"' for code, name in sorted(NMT_STATES.items()))
    return f"VAL_ {0x700 + node} state {states} ;"


def _encoder_messages(vehicle: VehicleParameters) -> list[str]:
    messages = []
    for cob_id in dict.fromkeys(encoder.cob_id for encoder in vehicle.encoders):
        encoders = [encoder for encoder in vehicle.encoders if encoder.cob_id == cob_id]
        size = max((encoder.start_bit + encoder.bits + 7) // 8 for encoder in encoders)
        name = "_".join(_identifier(encoder.channel) for encoder in encoders)
        name = name if len(name) <= _LONGEST_NAME else f"TPDO_{cob_id:03X}"
        lines = [f"BO_ {cob_id} {name}: {size} {node_name(encoders[0].node)}"]
        for encoder in encoders:
            bits = f"{encoder.start_bit}|{encoder.bits}@1{'-' if encoder.signed else '+'}"
            lines.append(_signal(_identifier(encoder.channel), bits, encoder_conversion(encoder, vehicle)))
        messages.append("\n".join([*lines, ""]))
    return messages


def _drive_messages(vehicle: VehicleParameters) -> list[str]:
    return [
        f"BO_ {drive.cob_id} target_{_identifier(drive.wheel)}: {drive.start_bit // 8 + 4} {_READER}\n"
        + _signal(
            f"target_{_identifier(drive.wheel)}",
            f"{drive.start_bit}|32@1-",
            drive_conversion(drive),
            node_name(drive.node),
        )
        + "\n"
        for drive in vehicle.drives
    ]


def _node_messages(node: int) -> str:
    return (
        f"BO_ {0x80 + node} EMCY_{node}: 8 node_{node}\n"
        f' SG_ error_code : 0|16@1+ (1,0) [0|0] "" {_READER}\n'
        f' SG_ error_register : 16|8@1+ (1,0) [0|0] "" {_READER}\n\n'
    ) + heartbeat_message(node, _READER)


def _signal(name: str, bits: str, conversion: Conversion, reader: str = _READER) -> str:
    factor, offset, unit = conversion
    return f' SG_ {name} : {bits} ({factor!r},{offset!r}) [0|0] "{unit}" {reader}'


def _identifier(channel: str) -> str:
    return channel.replace(".", "_")
