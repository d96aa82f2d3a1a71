"""Errors of the driver, with the data that a caller needs to react."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from omnimate.files.logs.canopen_words import sdo_abort_in_words
from omnimate.vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from omnimate.driver.robot.events import Trouble

# What to do about an SDO abort, by its code; CiA 301 lists the codes.
ABORT_ADVICE = {
    0x06010001: "the object can only be written, so that its value cannot be checked",
    0x06010002: "set the value with the manufacturer's tool, or change vehicle.toml to what the device has",
    0x08000022: "set the node pre-operational or switch it off and on, then try again",
}
GENERAL_ADVICE = "see the device's manual for this object, or use a device that has it"


def in_one_line(error: Exception) -> str:
    """Return the first line of an interface's error, without the traceback that python-can adds to some."""
    text = str(error).partition("Traceback (most recent call last)")[0].strip(" :\n").partition("\n")[0]
    return text or type(error).__name__


class DriverError(OmnimateError):
    """The root of the driver's errors."""


class BusError(DriverError):
    """A bus at `url` that cannot be opened, or that was lost and did not come back."""

    def __init__(self, url: str, problem: str) -> None:
        super().__init__(f"{url}: {problem}")
        self.url = url


class BusLost(DriverError):  # noqa: N818  # a state of the bus that the driver recovers from
    """The interface failed while sending or receiving; `cause` is its error's text in one line."""

    def __init__(self, error: Exception) -> None:
        cause = in_one_line(error)
        super().__init__(
            f"the bus interface failed: {cause}; check the adapter, its cable and the power of the bus"
        )
        self.cause = cause


class BusOverload(DriverError):  # noqa: N818  # named after what it says
    """A configuration that would fill the bus; `load` is the forecast share in use, 1 is full."""

    def __init__(self, load: float, limit: float, bitrate: int) -> None:
        super().__init__(
            f"forecast bus load {load:.0%} of {bitrate} bit/s; at most {limit:.0%} is accepted: "
            "choose a longer bus.sync_period or a higher bus.bitrate"
        )
        self.load = load


class NodeError(DriverError):
    """An error that concerns one node; `problem` is without the node and without advice."""

    def __init__(self, node: int, problem: str, advice: str) -> None:
        super().__init__(f"node {node}: {problem}; {advice}")
        self.node = node
        self.problem = problem


class NodeMissing(NodeError):  # noqa: N818  # named after what it says
    """A node that does not answer SDO requests; `names` are its channels and drives."""

    def __init__(self, node: int, names: Sequence[str]) -> None:
        super().__init__(
            node,
            f"no answer to SDO; expected the device of {', '.join(names)}",
            "check its power, cable, bit rate and node id",
        )
        self.names = tuple(names)


class TwoDevices(NodeError):  # noqa: N818  # named after what it says
    """Two devices that have the same node id."""

    def __init__(self, node: int) -> None:
        super().__init__(
            node,
            "each SDO request is answered twice; expected one device with this node id",
            "give one of the two devices another node id",
        )


class WrongDevice(NodeError):  # noqa: N818  # named after what it says
    """A node that is another device than `vehicle.toml` states.

    Attributes:
        key: Key of the encoder in `vehicle.toml`: profile, vendor, product or serial.
        expected: Value in `vehicle.toml`.
        actual: Value in the device.
    """

    def __init__(self, node: int, where: str, key: str, expected: str, actual: str) -> None:
        super().__init__(
            node,
            f"{key} is {actual} in object {where}, but vehicle.toml expects {expected}",
            f"check whether a device was swapped or renumbered; if it is the right one, correct {key} in "
            "vehicle.toml",
        )
        self.key = key
        self.expected = expected
        self.actual = actual


class SdoError(NodeError):
    """An SDO transfer of the object `index`, `subindex` that failed."""

    def __init__(self, node: int, index: int, subindex: int, problem: str, advice: str) -> None:
        super().__init__(node, problem, advice)
        self.index = index
        self.subindex = subindex


class SdoSilent(SdoError):  # noqa: N818  # named after what it says
    """A node that stopped answering SDO in the middle of a dialogue."""

    def __init__(self, node: int, index: int, subindex: int, problem: str) -> None:
        super().__init__(
            node,
            index,
            subindex,
            f"no valid SDO answer for {index:04X}h:{subindex:02X}: {problem}",
            "expected one answer to each request: check its power and cable, and that no other SDO client "
            "addresses this node",
        )


class SdoRefused(SdoError):  # noqa: N818  # named after what it says
    """A node that aborted an SDO transfer with `abort_code`, as CiA 301 lists them."""

    def __init__(
        self, node: int, index: int, subindex: int, abort_code: int, access: Literal["read", "write"]
    ) -> None:
        super().__init__(
            node,
            index,
            subindex,
            f"refused to {access} {index:04X}h:{subindex:02X}: "
            f"{sdo_abort_in_words(abort_code)} ({abort_code:08X}h)",
            f"expected it to be {'readable' if access == 'read' else 'writable'}: "
            f"{ABORT_ADVICE.get(abort_code, GENERAL_ADVICE)}",
        )
        self.abort_code = abort_code


class NotTaken(SdoError):  # noqa: N818  # named after what it says
    """A node that confirmed the value `wrote`, and `reads` another one when it is read back."""

    def __init__(self, node: int, index: int, subindex: int, wrote: int, reads: int) -> None:
        super().__init__(
            node,
            index,
            subindex,
            f"{index:04X}h:{subindex:02X} reads back {reads:X}h; expected {wrote:X}h, which was written and "
            "confirmed",
            "see the device's manual for the values that it takes",
        )
        self.wrote = wrote
        self.reads = reads


class MappingImpossible(NodeError):  # noqa: N818  # named after what it says
    """Fields of `vehicle.toml` that no PDO of this node can carry."""


class DriveError(NodeError):
    """A drive that does not reach a state of CiA 402; `status` is its status word 6041h."""

    def __init__(self, node: int, status: int, expected: str) -> None:
        super().__init__(
            node,
            f"status word 6041h is {status:04X}h; expected {expected}",
            "look up the cause in the drive's own diagnosis",
        )
        self.status = status


class NotEnabled(DriverError):  # noqa: N818  # named after what it says
    """A command while the drives are not enabled, for a `reason`."""

    def __init__(self, reason: str, advice: str = "call enable() first") -> None:
        super().__init__(f"the drives are not enabled: {reason}; {advice}")
        self.reason = reason


class DrivesStopped(DriverError):  # noqa: N818  # named after what it says
    """A command after a drive has stopped all wheels; of its `troubles` the first one is first."""

    def __init__(self, troubles: Sequence[Trouble], names: Mapping[int, str]) -> None:
        causes = [
            trouble.what
            if trouble.node is None
            else f"node {trouble.node} ({names[trouble.node]}): {trouble.what}"
            for trouble in troubles
        ]
        super().__init__(
            f"all wheels were stopped, because of {'; '.join(causes)}; put the cause right, then enable the "
            "drives again, which resets a fault"
        )
        self.troubles = tuple(troubles)


class BadCommand(DriverError):  # noqa: N818  # named after what it says
    """Wheel speeds that cannot be sent to the drives."""


class EdsError(DriverError):
    """An EDS or DCF file, `source`, that cannot be read even tolerantly."""

    def __init__(self, source: str, problem: str) -> None:
        super().__init__(
            f"{source}: {problem}; get the file from the device's manufacturer, or leave it out: the driver "
            "needs no EDS"
        )
        self.source = source


class NoSync(DriverError):  # noqa: N818  # named after what it says
    """Neither SYNC nor a PDO of the vehicle in the time `waited` [s] on a bus that is only listened to."""

    def __init__(self, waited: float) -> None:
        super().__init__(
            f"no SYNC (COB-ID 080h) and no PDO of this vehicle within {waited:g} s; "
            "expected a master or a replay on this bus: start it, or let the driver produce SYNC itself"
        )
        self.waited = waited
