"""SDO aborts of the simulated devices, with the codes of CiA 301 table 22."""

from __future__ import annotations

from enum import IntEnum

from omnimate.files.logs.canopen_words import sdo_abort_in_words
from omnimate.vcan_sim.errors import SimulationError


class Abort(IntEnum):
    """Abort code: the reason why a device refuses an SDO request."""

    TOGGLE = 0x05030000
    COMMAND = 0x05040001
    BLOCK_SIZE = 0x05040002
    SEQUENCE = 0x05040003
    CRC = 0x05040004
    READ_ONLY = 0x06010002
    NO_OBJECT = 0x06020000
    NOT_MAPPABLE = 0x06040041
    PDO_LENGTH = 0x06040042
    LENGTH = 0x06070010
    NO_SUBINDEX = 0x06090011
    VALUE = 0x06090030
    NOT_STORED = 0x08000020
    STATE = 0x08000022
    NO_DATA = 0x08000024


class SdoAbort(SimulationError):  # noqa: N818 - the word of CiA 301
    """An SDO request that a device answers with an abort.

    Attributes:
        code: Abort code of CiA 301.
    """

    def __init__(self, code: int) -> None:
        super().__init__(f"SDO abort {code:08X}h: {sdo_abort_in_words(code)}")
        self.code = code
