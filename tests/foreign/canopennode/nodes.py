"""CANopen devices on CANopenNode, built by the system's C compiler from the sources that are there.

`CANOPENNODE` in the environment names a checkout of https://github.com/CANopenNode/CANopenNode; without it,
the sources are those in `../shared/foreign/CANopenNode`. CONTRIBUTING.md says which states were run.
"""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import weakref
from functools import partial
from pathlib import Path

from tests.foreign.devices import NMT_STATE, DrivenWheel
from tests.samples import SHARED

HERE = Path(__file__).parent
SOURCES = Path(os.environ.get("CANOPENNODE") or SHARED / "foreign" / "CANopenNode")
MODULES = ("ODinterface", "Emergency", "NMT_Heartbeat", "HBconsumer", "SYNC", "PDO", "SDOserver")
# A version whose functions take something else does not build, instead of being called wrongly.
STRICT = [
    f"-Werror={what}"
    for what in ("implicit-function-declaration", "incompatible-pointer-types", "int-conversion")
]
NMT_COMMAND = {state: command for command, state in NMT_STATE.items()}
DEVICE, U8, U16, U32 = ctypes.c_void_p, ctypes.c_uint8, ctypes.c_uint16, ctypes.c_uint32
MAPPING = U32 * 8
SEND = ctypes.CFUNCTYPE(None, U32, U8, ctypes.POINTER(U8))
FUNCTIONS = {  # of device.c: what each returns and takes
    "new": (DEVICE, U8, ctypes.c_bool, U8, MAPPING, MAPPING, SEND),
    "free": (None, DEVICE),
    "reset": (None, DEVICE),
    "get": (U32, DEVICE, U16, U8),
    "put": (None, DEVICE, U16, U8, U32),
    "protect": (None, DEVICE, U16, U8),
    "error": (None, DEVICE, U16),
    "state": (U8, DEVICE),
    "command": (None, DEVICE, U8),
    "process": (None, DEVICE, U32),
    "receive": (None, DEVICE, U16, U8, ctypes.c_char_p),
}


def what_is_missing():
    """Return in words what the build lacks; an empty text where it can be done."""
    if not (SOURCES / "301" / "CO_ODinterface.c").exists():
        return f"{SOURCES} has no sources of CANopenNode; set CANOPENNODE to a checkout (CONTRIBUTING.md)"
    return "" if shutil.which("cc") else "there is no C compiler (cc) for the devices on CANopenNode"


def build(folder):
    """Compile the devices into a folder; return them as a library."""
    made = folder / "device.so"
    command = ["cc", "-shared", "-fPIC", "-std=gnu11", "-O1", f"-I{SOURCES}", f"-I{HERE}", "-o", made]
    done = subprocess.run(
        [*command, *STRICT, HERE / "device.c", *(SOURCES / "301" / f"CO_{module}.c" for module in MODULES)],
        check=False,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    library = ctypes.CDLL(str(made))
    for name, (result, *arguments) in FUNCTIONS.items():
        function = getattr(library, f"device_{name}")
        function.restype, function.argtypes = result, arguments
    return library


class Node:
    """A device on CANopenNode, with the same interface to a test as a `ForeignNode`."""

    def __init__(self, library, node, is_drive, kind, tpdo, rpdo=()):
        self.id, self.now, self.is_powered, self.network = node, 0.0, True, None
        self._library = library
        self._send = SEND(lambda can_id, length, data: self.send(can_id, bytes(data[:length])))
        mappings = MAPPING(*tpdo), MAPPING(*rpdo)
        self._device = library.device_new(node, is_drive, kind, *mappings, self._send)
        weakref.finalize(self, library.device_free, self._device)

    @property
    def state(self):
        """Its NMT state; setting it is as if it had heard the command."""
        return self._library.device_state(self._device)

    @state.setter
    def state(self, state):
        self._library.device_command(self._device, NMT_COMMAND[state])

    def number(self, index, subindex=0):
        """Return an object as an unsigned number."""
        return self._library.device_get(self._device, index, subindex)

    def put(self, index, subindex, value):
        """Set an object to an unsigned number, as its application would."""
        self._library.device_put(self._device, index, subindex, value)

    def protect(self, index, subindex=0):
        """Refuse to write an object."""
        self._library.device_protect(self._device, index, subindex)

    def send(self, can_id, data):
        """Send a frame, unless the node is without power."""
        if self.is_powered:
            self.network.send_message(can_id, data)

    def reset(self):
        """Restart with the defaults of all objects, as the return of the power does."""
        self.is_powered = True
        self._library.device_reset(self._device)

    def power_off(self):
        """Stop sending and hearing."""
        self.is_powered = False

    def tick(self, now):
        """Let time pass until `now` [s]."""
        passed, self.now = now - self.now, now
        if self.is_powered:
            self.sample()
            self._library.device_process(self._device, round(1e6 * passed))

    def sample(self):
        """Put what its application measures into its objects."""

    def associate_network(self, network):
        """Hear what comes to this node on a network."""
        self.network = network
        network.hearers.append(self._receive)

    def _receive(self, can_id, data, _timestamp):
        is_for_another = can_id & 0x780 == 0x600 and can_id != 0x600 + self.id
        if self.is_powered and not is_for_another:
            self.sample()
            self._library.device_receive(self._device, can_id, len(data), bytes(data))


class CanOpenNodeEncoder(Node):
    """A CiA 406 encoder; `position` counts on while it has power."""

    def __init__(self, library, node, kind=254):
        super().__init__(library, node, False, kind, (0x60040020,))
        self.position = 0.0

    def reset(self):
        """Count from 0 again."""
        super().reset()
        self.position = 0.0

    def sample(self):
        """Put its position into the object that it sends."""
        self.put(0x6004, 0, round(self.position) % 2**32)


class CanOpenNodeDrive(DrivenWheel, Node):
    """A CiA 402 drive that turns the wheel of `encoder`, with the options of `ForeignDrive`."""

    def __init__(self, library, node, encoder, status=None, rpdo=(0x60400010,), access="rw"):
        mapped = {"first": (0x60410010, 0x60610008), "last": (0x60610008, 0x60410010)}.get(status, ())
        super().__init__(library, node, True, 255, mapped, rpdo)
        if access == "ro":
            for subindex in range(9):
                self.protect(0x1600, subindex)
        self.encoder = encoder

    @property
    def status(self):
        """Its status word."""
        return self.number(0x6041)

    @status.setter
    def status(self, status):
        self.put(0x6041, 0, status)

    def emergency(self, code):
        """Send EMCY and stay as it is."""
        self._library.device_error(self._device, code)


def family(library):
    """Return what makes these devices, for `robots.FAMILY`."""
    return {"encoder": partial(CanOpenNodeEncoder, library), "drive": partial(CanOpenNodeDrive, library)}
