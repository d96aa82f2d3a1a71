"""A vehicle as a DBC file: every PDO a message, every channel a signal in radians or metres."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.logs.canopen_words import NMT_STATES, SYNC_ID
from omnimate.logs.pdo_units import drive_conversion, encoder_conversion

if TYPE_CHECKING:
    from omnimate.logs.pdo_units import Conversion
    from omnimate.vehicle.parameters import VehicleParameters

_LONGEST_NAME = 32  # characters of a DBC name
_READER = "host"


def format_dbc(vehicle: VehicleParameters) -> str:
    """Return the text of a DBC file: SYNC, PDOs, and heartbeat and EMCY of every node."""
    nodes = sorted({owner.node for owner in vehicle.encoders} | {drive.node for drive in vehicle.drives})
    head = [
        'VERSION ""',
        "",
        "NS_ :",
        "",
        "BS_:",
        "",
        f"BU_: {_READER} {' '.join(f'node_{node}' for node in nodes)}",
        "",
        f"BO_ {SYNC_ID} SYNC: 0 {_READER}",
        "",
    ]
    blocks = [*_encoder_messages(vehicle), *_drive_messages(vehicle), *map(_node_messages, nodes)]
    states = " ".join(f'{code} "{name}"' for code, name in sorted(NMT_STATES.items()))
    values = [f"VAL_ {0x700 + node} state {states} ;" for node in nodes]
    name = vehicle.name.replace("\\", "/").replace('"', "'")
    return "\n".join([*head, *blocks, f'CM_ "{name}";', *values, ""])


def _encoder_messages(vehicle: VehicleParameters) -> list[str]:
    messages = []
    for cob_id in dict.fromkeys(encoder.cob_id for encoder in vehicle.encoders):
        encoders = [encoder for encoder in vehicle.encoders if encoder.cob_id == cob_id]
        size = max((encoder.start_bit + encoder.bits + 7) // 8 for encoder in encoders)
        name = "_".join(_identifier(encoder.channel) for encoder in encoders)
        name = name if len(name) <= _LONGEST_NAME else f"TPDO_{cob_id:03X}"
        lines = [f"BO_ {cob_id} {name}: {size} node_{encoders[0].node}"]
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
            f"node_{drive.node}",
        )
        + "\n"
        for drive in vehicle.drives
    ]


def _node_messages(node: int) -> str:
    return (
        f"BO_ {0x80 + node} EMCY_{node}: 8 node_{node}\n"
        f' SG_ error_code : 0|16@1+ (1,0) [0|0] "" {_READER}\n'
        f' SG_ error_register : 16|8@1+ (1,0) [0|0] "" {_READER}\n\n'
        f"BO_ {0x700 + node} heartbeat_{node}: 1 node_{node}\n"
        f' SG_ state : 0|7@1+ (1,0) [0|0] "" {_READER}\n'
    )


def _signal(name: str, bits: str, conversion: Conversion, reader: str = _READER) -> str:
    factor, offset, unit = conversion
    return f' SG_ {name} : {bits} ({factor!r},{offset!r}) [0|0] "{unit}" {reader}'


def _identifier(channel: str) -> str:
    return channel.replace(".", "_")
