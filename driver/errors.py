"""What can go wrong on a bus, with the data that a caller needs to react."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vehicle.canopen_words import sdo_abort_in_words
from vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from collections.abc import Sequence


class DriverError(OmnimateError):
    """Anything that the driver raises on purpose."""


class BusError(DriverError):
    """A bus that cannot be opened, or that is gone for good.

    Attributes:
        url: as it was given.
    """

    def __init__(self, url: str, problem: str) -> None:
        super().__init__(f"{url}: {problem}")
        self.url = url


class BusLost(DriverError):  # noqa: N818  # a state of the bus that the driver recovers from
    """The interface failed while sending or receiving.

    Attributes:
        cause: the interface's own error.
    """

    def __init__(self, cause: Exception) -> None:
        super().__init__(f"the bus interface failed: {cause}")
        self.cause = cause


class BusOverload(DriverError):  # noqa: N818  # named after what it says
    """A configuration that would fill the bus.

    Attributes:
        load: forecast share of the bus, 1 is full.
    """

    def __init__(self, load: float, limit: float, bitrate: int) -> None:
        super().__init__(
            f"forecast bus load {load:.0%} of {bitrate} bit/s; at most {limit:.0%} is accepted: "
            "choose a longer bus.sync_period or a higher bus.bitrate"
        )
        self.load = load


class NodeError(DriverError):
    """Something about one node.

    Attributes:
        node: CANopen node id.
    """

    def __init__(self, node: int, problem: str) -> None:
        super().__init__(f"node {node}: {problem}")
        self.node = node


class NodeMissing(NodeError):  # noqa: N818  # named after what it says
    """A node that does not answer SDO requests.

    Attributes:
        channels: what it should have measured or driven.
    """

    def __init__(self, node: int, channels: Sequence[str]) -> None:
        super().__init__(
            node,
            f"no answer to SDO; expected the device of {', '.join(channels)}: "
            "check its power, cable, bit rate and node id",
        )
        self.channels = tuple(channels)


class WrongDevice(NodeError):  # noqa: N818  # named after what it says
    """A node that is not the device that `vehicle.toml` states.

    Attributes:
        key: of `vehicle.toml`.
        expected: value there.
        found: value in the device.
    """

    def __init__(self, node: int, key: str, expected: str, found: str) -> None:
        super().__init__(
            node,
            f"{key}: found {found}, vehicle.toml expects {expected}; was a device swapped or renumbered?",
        )
        self.key = key
        self.expected = expected
        self.found = found


class SdoSilent(NodeError):  # noqa: N818  # named after what it says
    """A node that stopped answering SDO in the middle of a dialogue.

    Attributes:
        index: object.
        subindex: of it.
    """

    def __init__(self, node: int, index: int, subindex: int, problem: str) -> None:
        super().__init__(node, f"no valid SDO answer for {index:04X}h:{subindex:02X}: {problem}")
        self.index = index
        self.subindex = subindex


class SdoRefused(NodeError):  # noqa: N818  # named after what it says
    """A node that aborted an SDO transfer.

    Attributes:
        index: object.
        subindex: of it.
        abort_code: as CiA 301 lists them.
    """

    def __init__(self, node: int, index: int, subindex: int, abort_code: int) -> None:
        super().__init__(
            node,
            f"refused {index:04X}h:{subindex:02X}: {sdo_abort_in_words(abort_code)} ({abort_code:08X}h)",
        )
        self.index = index
        self.subindex = subindex
        self.abort_code = abort_code


class NotTaken(NodeError):  # noqa: N818  # named after what it says
    """A node that confirmed a value and shows another one when read back.

    Attributes:
        index: object.
        subindex: of it.
        wrote: value.
        reads: value.
    """

    def __init__(self, node: int, index: int, subindex: int, wrote: int, reads: int) -> None:
        super().__init__(node, f"{index:04X}h:{subindex:02X}: wrote {wrote:X}h, reads back {reads:X}h")
        self.index = index
        self.subindex = subindex
        self.wrote = wrote
        self.reads = reads


class MappingImpossible(NodeError):  # noqa: N818  # named after what it says
    """Fields of `vehicle.toml` that no PDO of this node can carry."""


class DriveError(NodeError):
    """A drive that does not reach a state of CiA 402.

    Attributes:
        status: its status word 6041h.
    """

    def __init__(self, node: int, status: int, wanted: str) -> None:
        super().__init__(node, f"status word {status:04X}h; expected {wanted}: see the drive's own diagnosis")
        self.status = status


class NotEnabled(DriverError):  # noqa: N818  # named after what it says
    """A command while the drives are not enabled."""

    def __init__(self, reason: str) -> None:
        super().__init__(f"the drives are not enabled ({reason}); call enable() first")
        self.reason = reason


class BadCommand(DriverError):  # noqa: N818  # named after what it says
    """Wheel speeds that no drive can be given."""


class EdsError(DriverError):
    """An EDS or DCF file that cannot be read even tolerantly.

    Attributes:
        source: the file's name.
    """

    def __init__(self, source: str, problem: str) -> None:
        super().__init__(f"{source}: {problem}")
        self.source = source


class NoSync(DriverError):  # noqa: N818  # named after what it says
    """Nobody produces SYNC on a bus that is only listened to.

    Attributes:
        waited: [s].
    """

    def __init__(self, waited: float) -> None:
        super().__init__(
            f"no SYNC (COB-ID 080h) within {waited:g} s; "
            "expected a master or a replay on this bus: start it, or let the driver produce SYNC itself"
        )
        self.waited = waited
