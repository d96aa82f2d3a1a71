"""The errors of the simulated vehicle and its bus, and the SDO aborts of its devices."""

from __future__ import annotations

from enum import IntEnum

from omnimate.files.logs.canopen_words import sdo_abort_in_words
from omnimate.vehicle.errors import OmnimateError


class SimulationError(OmnimateError):
    """A simulation that cannot be set up, or cannot continue."""


class FaultError(SimulationError):
    """A `fault` whose text cannot be parsed, or that the vehicle cannot have."""

    def __init__(self, fault: str, problem: str) -> None:
        super().__init__(f"fault {fault!r}: {problem}")
        self.fault = fault


class BumpError(SimulationError):
    """A `text` of a bump that cannot be parsed."""

    def __init__(self, text: str, problem: str) -> None:
        super().__init__(f"bump {text!r}: {problem}")
        self.text = text


class HubError(SimulationError):
    """A hub that cannot listen on its `host` and TCP `port`."""

    def __init__(self, host: str, port: int, problem: str) -> None:
        super().__init__(f"{host}:{port}: {problem}")
        self.host = host
        self.port = port


class ProtocolError(SimulationError):
    """A client's `command`, as far as it was read, that is not of the socketcand protocol."""

    def __init__(self, command: str, problem: str) -> None:
        super().__init__(f"{problem}: {command[:80]!r}")
        self.command = command
        self.problem = problem


class EndStopError(SimulationError):
    """A slider at its end stop: the trucks did not keep their distance.

    The `time` is since the start [s]; `length` is that of the link [m].
    """

    def __init__(self, time: float, length: float) -> None:
        super().__init__(
            f"linkage at its end stop after {time:.2f} s, {length:.3f} m long; expected truck b to keep its "
            "distance from truck a: lower the speed or allow a longer stroke"
        )
        self.time = time
        self.length = length


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
    """An SDO request that a device answers with an abort `code` of CiA 301."""

    def __init__(self, code: int) -> None:
        super().__init__(f"SDO abort {code:08X}h: {sdo_abort_in_words(code)}")
        self.code = code
