"""Emergencies: EMCY messages, the error register 1001h and the error history 1003h (CiA 301 7.2.7)."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING

from omnimate.vcan_sim.errors import Abort, SdoAbort

if TYPE_CHECKING:
    from collections.abc import Callable

_EMCY = struct.Struct("<HB5x")
_HISTORY = 8  # errors that 1003h keeps

# Error register bit of each class of error codes (the code's highest digit); bit 0 is always set.
_REGISTER_BITS = {0x2: 0x02, 0x3: 0x04, 0x4: 0x08, 0x8: 0x10, 0xF: 0x80}

# EMCY error codes of CiA 301.
LENGTH_ERROR = 0x8210
RPDO_TIMEOUT = 0x8250
HEARTBEAT_ERROR = 0x8130
SYNC_LENGTH = 0x8240


class Emergency:
    """The active errors of one device, and the history of errors."""

    def __init__(self, send: Callable[[bytes], None]) -> None:
        self._send = send
        self._active: list[int] = []
        self._history: list[int] = []

    @property
    def code(self) -> int:
        """Code of the last error that is still active, as in 603Fh of a drive; 0 if none is."""
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
        """Clear an error; if no other is active, EMCY 0000h is sent."""
        if code in self._active:
            self._active.remove(code)
            if not self._active:
                self._send(_EMCY.pack(0x0000, 0x00))

    def reset(self) -> None:
        """Clear errors and history without sending, as at power-on."""
        self._active.clear()
        self._history.clear()

    def history(self, sub: int) -> int:
        """Return a sub-index of 1003h; raise SdoAbort if the history is shorter."""
        if sub == 0:
            return len(self._history)
        if sub > len(self._history):
            raise SdoAbort(Abort.NO_DATA)
        return self._history[sub - 1]

    def erase_history(self, value: int) -> None:
        """Clear the history if 0 is written to 1003h:0; raise SdoAbort for any other value."""
        if value != 0:
            raise SdoAbort(Abort.VALUE)
        self._history.clear()
