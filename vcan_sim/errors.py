"""The errors of the simulated vehicle and its bus."""

from __future__ import annotations

from omnimate.vehicle.errors import OmnimateError


class SimulationError(OmnimateError):
    """A simulation that cannot be set up, or cannot continue."""


class FaultError(SimulationError):
    """A text of a device fault that cannot be parsed, or a fault that the vehicle cannot have.

    Attributes:
        fault: Fault as it was written.
    """

    def __init__(self, fault: str, problem: str) -> None:
        super().__init__(f"fault {fault!r}: {problem}")
        self.fault = fault


class BumpError(SimulationError):
    """A text of a bump that cannot be parsed.

    Attributes:
        text: The bump as it was written.
    """

    def __init__(self, text: str, problem: str) -> None:
        super().__init__(f"bump {text!r}: {problem}")
        self.text = text


class HubError(SimulationError):
    """A hub that cannot listen on its address.

    Attributes:
        host: Address on which the hub was to listen.
        port: TCP port on which the hub was to listen.
    """

    def __init__(self, host: str, port: int, problem: str) -> None:
        super().__init__(f"{host}:{port}: {problem}")
        self.host = host
        self.port = port


class ProtocolError(SimulationError):
    """A client's command that is not of the socketcand protocol.

    Attributes:
        command: Command of the client, as far as it was read.
    """

    def __init__(self, command: str, problem: str) -> None:
        super().__init__(f"{problem}: {command[:80]!r}")
        self.command = command
        self.problem = problem


class EndStopError(SimulationError):
    """A slider that was driven to its end stop: the trucks did not keep their distance.

    Attributes:
        time: Time since the start [s].
        length: Length of the link [m].
    """

    def __init__(self, time: float, length: float) -> None:
        super().__init__(
            f"linkage at its end stop after {time:.2f} s, {length:.3f} m long; expected truck b to keep its "
            "distance from truck a: lower the speed or allow a longer stroke"
        )
        self.time = time
        self.length = length
