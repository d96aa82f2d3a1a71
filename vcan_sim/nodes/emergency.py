"""Emergencies: EMCY messages, the error register 1001h and the error history 1003h (CiA 301 7.2.7)."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING

from omnimate.vcan_sim.errors import SdoAbort
from omnimate.vcan_sim.nodes.abort import Abort

if TYPE_CHECKING:
    from collections.abc import Callable

_EMCY = struct.Struct("<HB5x")
_HISTORY = 8

# Error register bit of each class of error codes (the code's highest digit); bit 0 is always set.
_REGISTER_BITS = {0x2: 0x02, 0x3: 0x04, 0x4: 0x08, 0x8: 0x10, 0xF: 0x80}

LENGTH_ERROR = 0x8210
RPDO_TIMEOUT = 0x8250
HEARTBEAT_ERROR = 0x8130
SYNC_LENGTH = 0x8240


class Emergency:
    """The errors of one device: those active, and the last ones."""

    def __init__(self, send: Callable[[bytes], None]) -> None:
        self._send = send
        self._active: list[int] = []
        self._history: list[int] = []

    @property
    def code(self) -> int:
        """The last error that is active still, as a drive shows it in 603Fh; 0 where none is."""
        return self._active[-1] if self._active else 0

    @property
    def register(self) -> int:
        """The error register 1001h."""
        bits = 0x01 if self._active else 0x00
        for code in self._active:
            bits |= _REGISTER_BITS.get(code >> 12, 0x00)
        return bits

    def set(self, code: int) -> None:
        """Report an error once, until it is cleared."""
        if code not in self._active:
            self._active.append(code)
            self._history = [code, *self._history][:_HISTORY]
            self._send(_EMCY.pack(code, self.register))

    def clear(self, code: int) -> None:
        """Take an error back: 0000h where it was the last one, else nothing is sent."""
        if code in self._active:
            self._active.remove(code)
            if not self._active:
                self._send(_EMCY.pack(0x0000, 0x00))

    def reset(self) -> None:
        """Forget all, as after power-on."""
        self._active.clear()
        self._history.clear()

    def history(self, sub: int) -> int:
        """Return a sub-index of 1003h; raise SdoAbort where no such error happened."""
        if sub == 0:
            return len(self._history)
        if sub > len(self._history):
            raise SdoAbort(Abort.NO_DATA)
        return self._history[sub - 1]

    def erase_history(self, value: int) -> None:
        """Empty the history, for a write of 0 to 1003h:0; raise SdoAbort for any other value."""
        if value != 0:
            raise SdoAbort(Abort.VALUE)
        self._history.clear()
