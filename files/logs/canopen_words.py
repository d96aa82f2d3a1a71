"""Description of CANopen frames by CiA 301: NMT, SYNC, EMCY, SDO, heartbeat, predefined COB-IDs."""

from __future__ import annotations

# COB-IDs of the predefined connection set (CiA 301); in the second line those of node 0.
NMT_ID, SYNC_ID, TIME_ID = 0x000, 0x080, 0x100
EMCY, SDO_ANSWER, SDO_REQUEST, HEARTBEAT = 0x080, 0x580, 0x600, 0x700
LSS_IDS = {0x7E5: "LSS command", 0x7E4: "LSS answer"}

NMT_START, NMT_STOP, NMT_PRE_OPERATIONAL = 0x01, 0x02, 0x80
NMT_RESET_NODE, NMT_RESET_COMMUNICATION = 0x81, 0x82
NMT_COMMANDS = {
    NMT_START: "start",
    NMT_STOP: "stop",
    NMT_PRE_OPERATIONAL: "enter pre-operational",
    NMT_RESET_NODE: "reset node",
    NMT_RESET_COMMUNICATION: "reset communication",
}
BOOT_UP, STOPPED, OPERATIONAL, PRE_OPERATIONAL = 0x00, 0x04, 0x05, 0x7F
NMT_STATES = {
    BOOT_UP: "boot-up",
    STOPPED: "stopped",
    OPERATIONAL: "operational",
    PRE_OPERATIONAL: "pre-operational",
}

EMCY_CODES = {
    0x0000: "error reset or no error",
    0x8110: "CAN overrun, objects lost",
    0x8120: "CAN in error passive mode",
    0x8130: "life guard or heartbeat error",
    0x8140: "recovered from bus-off",
    0x8150: "transmit COB-ID collision",
    0x8210: "PDO not processed due to length error",
    0x8220: "PDO length exceeded",
    0x8230: "DAM MPDO not processed, destination object not available",
    0x8240: "unexpected SYNC data length",
    0x8250: "RPDO timeout",
}
EMCY_CLASSES = {
    0x10: "generic error",
    0x20: "current",
    0x21: "current, device input side",
    0x22: "current inside the device",
    0x23: "current, device output side",
    0x30: "voltage",
    0x31: "mains voltage",
    0x32: "voltage inside the device",
    0x33: "output voltage",
    0x40: "temperature",
    0x41: "ambient temperature",
    0x42: "device temperature",
    0x50: "device hardware",
    0x60: "device software",
    0x61: "internal software",
    0x62: "user software",
    0x63: "data set",
    0x70: "additional modules",
    0x80: "monitoring",
    0x81: "communication",
    0x82: "protocol error",
    0x90: "external error",
    0xF0: "additional functions",
    0xFF: "device specific",
}
ERROR_REGISTER = (  # bits 0 to 7 of 1001h
    *("generic", "current", "voltage", "temperature", "communication", "device profile specific"),
    *("reserved bit 6", "manufacturer specific"),
)
SDO_ABORT_CODES = {
    0x05030000: "toggle bit not alternated",
    0x05040000: "SDO protocol timed out",
    0x05040001: "command specifier not valid or unknown",
    0x05040002: "invalid block size",
    0x05040003: "invalid sequence number",
    0x05040004: "CRC error",
    0x05040005: "out of memory",
    0x06010000: "unsupported access to an object",
    0x06010001: "attempt to read a write-only object",
    0x06010002: "attempt to write a read-only object",
    0x06020000: "object does not exist in the object dictionary",
    0x06040041: "object cannot be mapped to the PDO",
    0x06040042: "mapped objects would exceed the PDO length",
    0x06040043: "general parameter incompatibility",
    0x06040047: "general internal incompatibility in the device",
    0x06060000: "access failed due to a hardware error",
    0x06070010: "data type does not match, length of parameter does not match",
    0x06070012: "data type does not match, length of parameter too high",
    0x06070013: "data type does not match, length of parameter too low",
    0x06090011: "sub-index does not exist",
    0x06090030: "invalid value for parameter",
    0x06090031: "value of parameter written too high",
    0x06090032: "value of parameter written too low",
    0x06090036: "maximum value is less than minimum value",
    0x060A0023: "resource not available: SDO connection",
    0x08000000: "general error",
    0x08000020: "data cannot be transferred or stored to the application",
    0x08000021: "data cannot be transferred because of local control",
    0x08000022: "data cannot be transferred because of the present device state",
    0x08000023: "no object dictionary is present, or its generation failed",
    0x08000024: "no data available",
}

# Function code (bits 7 to 10 of the COB-ID) in the predefined connection set, CiA 301 table 39.
_PDO_FUNCTIONS = {
    0x180: "TPDO1",
    0x200: "RPDO1",
    0x280: "TPDO2",
    0x300: "RPDO2",
    0x380: "TPDO3",
    0x400: "RPDO3",
    0x480: "TPDO4",
    0x500: "RPDO4",
}
_CLIENT_INITIATES = {1: "download", 2: "upload", 5: "block upload", 6: "block download"}
_SERVER_ANSWERS = {2: "answer", 3: "confirmed", 5: "block download", 6: "block upload"}
_BLOCK_SUBCOMMANDS = {5: 0x03, 6: 0x01}  # bits that are 0 where a block transfer begins


def error_register_in_words(register: int) -> str:
    """Return the errors in a device's error register 1001h, such as `generic, temperature`."""
    return ", ".join(word for bit, word in enumerate(ERROR_REGISTER) if register >> bit & 1) or "no error"


def emcy_in_words(code: int) -> str:
    """Return the meaning of an emergency error code (16 bits), or of its class."""
    if code in EMCY_CODES:
        return EMCY_CODES[code]
    high = code >> 8
    return EMCY_CLASSES.get(high) or EMCY_CLASSES.get(high & 0xF0) or "unknown error code"


def emergency_in_words(data: bytes | bytearray) -> str:
    """Return error code, meaning and error register of an EMCY frame of at least three bytes."""
    code = int.from_bytes(data[:2], "little")
    return f"EMCY {code:04X}h: {emcy_in_words(code)} (error register {data[2]:02X}h)"


def sdo_abort_in_words(code: int) -> str:
    """Return the meaning of an SDO abort code (32 bits)."""
    return SDO_ABORT_CODES.get(code, "unknown abort code")


def nmt_state_in_words(state: int) -> str:
    """Return the NMT state in a heartbeat or node guarding answer; bit 7 is the guarding toggle."""
    return NMT_STATES.get(state & 0x7F, f"unknown state {state & 0x7F:02X}h")


def describe_frame(can_id: int, data: bytes, *, remote: bool = False) -> str | None:
    """Return the meaning of an 11-bit frame by the predefined connection set; None if it is not CANopen."""
    function, node = can_id & ~0x7F, can_id & 0x7F
    if can_id in LSS_IDS:
        return LSS_IDS[can_id]
    if not 0 <= can_id <= 0x7FF or (node == 0 and can_id not in {NMT_ID, SYNC_ID, TIME_ID}):
        return None
    if function in _PDO_FUNCTIONS:
        return f"{_PDO_FUNCTIONS[function]} of node {node}" + (", requested" if remote else "")
    describe = _SERVICES.get(function)
    return describe(node, data, remote) if describe else None


def _nmt(node: int, data: bytes, _remote: bool) -> str | None:
    if node or len(data) != 2:
        return None
    command = NMT_COMMANDS.get(data[0], f"unknown command {data[0]:02X}h")
    return f"NMT {command}, {f'node {data[1]}' if data[1] else 'all nodes'}"


def _sync_or_emcy(node: int, data: bytes, _remote: bool) -> str | None:
    if not node:
        return "SYNC" if len(data) <= 1 else None
    if not data:
        return f"EMCY of node {node}, empty"
    if len(data) < 3:
        return f"EMCY of node {node}, wrong length {len(data)}"
    code = int.from_bytes(data[:2], "little")
    return f"EMCY of node {node}: {code:04X}h {emcy_in_words(code)}, error register {data[2]:02X}h"


def _time(node: int, _data: bytes, _remote: bool) -> str | None:
    return None if node else "TIME"


def _heartbeat(node: int, data: bytes, remote: bool) -> str | None:
    if remote:
        return f"node guarding request to node {node}"
    if len(data) != 1:
        return None
    return f"heartbeat of node {node}: {nmt_state_in_words(data[0])}"


def _sdo_request(node: int, data: bytes, _remote: bool) -> str:
    segments = {0: "download segment", 3: "upload segment"}
    return f"SDO to node {node}: {_sdo(data, _CLIENT_INITIATES, segments, valued=1)}"


def _sdo_answer(node: int, data: bytes, _remote: bool) -> str:
    segments = {0: "upload segment", 1: "download segment confirmed"}
    return f"SDO from node {node}: {_sdo(data, _SERVER_ANSWERS, segments, valued=2)}"


def _sdo(data: bytes, initiates: dict[int, str], segments: dict[int, str], valued: int) -> str:
    if len(data) != 8:
        return f"wrong length {len(data)}"
    specifier = data[0] >> 5
    if specifier in initiates and not data[0] & _BLOCK_SUBCOMMANDS.get(specifier, 0):
        return f"{initiates[specifier]} {_object(data)}{_expedited(data, specifier == valued)}"
    return _segment_or_abort(data, segments)


def _segment_or_abort(data: bytes, segments: dict[int, str]) -> str:
    if data[0] == 0x80:
        code = int.from_bytes(data[4:8], "little")
        return f"abort of {_object(data)}, {code:08X}h {sdo_abort_in_words(code)}"
    return segments.get(data[0] >> 5, "block segment")


def _object(data: bytes) -> str:
    return f"{int.from_bytes(data[1:3], 'little'):04X}h:{data[3]:02X}"


def _expedited(data: bytes, carries_value: bool) -> str:
    if not carries_value or not data[0] & 0x02:
        return ""
    size = 4 - (data[0] >> 2 & 0x03) if data[0] & 0x01 else 4
    return f" = {int.from_bytes(data[4 : 4 + size], 'little'):0{2 * size}X}h"


_SERVICES = {
    NMT_ID: _nmt,
    EMCY: _sync_or_emcy,
    TIME_ID: _time,
    SDO_ANSWER: _sdo_answer,
    SDO_REQUEST: _sdo_request,
    HEARTBEAT: _heartbeat,
}
