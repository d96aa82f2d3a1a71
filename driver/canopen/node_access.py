"""Opens a bus to read or write the objects of one node, unless another master works there."""

from __future__ import annotations

import time
from contextlib import contextmanager
from typing import TYPE_CHECKING

from omnimate.driver.bus.bus import open_bus, receive
from omnimate.driver.bus.clock import WallClock
from omnimate.driver.canopen.network import BusNetwork
from omnimate.driver.errors import DriverError
from omnimate.files.logs.canopen_words import SYNC_ID

if TYPE_CHECKING:
    from collections.abc import Iterator

    import can
    from canopen.objectdictionary import ObjectDictionary

    from omnimate.driver.canopen.sdo import Sdo

LISTENING = 0.3  # [s] in which another master sends SYNC: 3.3 Hz or more
MAX_RESPONSES = 1 << 16  # answers of one transfer, 7 bytes each: objects of up to 450 kB
PERIOD = 1.0  # [s] between SYNCs of the clock, which sends none here


class MasterActiveError(DriverError):
    """A bus on which another master works."""

    def __init__(self, url: str) -> None:
        super().__init__(
            f"{url}: another master sends SYNC, so that a robot may drive; stop it, or add --force"
        )
        self.url = url


def require_no_other_master(bus: can.BusABC, url: str) -> None:
    """Listen to a bus for a moment; raises MasterActiveError where another master sends SYNC, or BusLost."""
    end = time.monotonic() + LISTENING
    while (left := end - time.monotonic()) > 0.0:
        message = receive(bus, left)
        if message is not None and message.arbitration_id == SYNC_ID and not message.is_extended_id:
            raise MasterActiveError(url)


@contextmanager
def open_node(
    url: str,
    node: int,
    dictionary: ObjectDictionary | None = None,
    *,
    timeout: float = 0.5,
    writes: bool = False,
) -> Iterator[Sdo]:
    """Give the objects of a node on a bus that is opened for them; to write, no other master may work.

    Without a dictionary, that of the profiles is used; an answer must come within `timeout` [s]. Raises
    BusError, or MasterActiveError where the node is to be written.
    """
    with open_bus(url) as bus:
        if writes:
            require_no_other_master(bus, url)
        network = BusNetwork(bus, WallClock(PERIOD))
        sdo = network.sdo(node, None if dictionary is None else {node: dictionary}, timeout)
        sdo.max_responses = MAX_RESPONSES
        yield sdo
