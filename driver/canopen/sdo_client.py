"""canopen's SDO client on a bus that no thread reads in the background."""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING

from canopen.sdo.client import SdoClient
from canopen.sdo.exceptions import SdoCommunicationError

from omnimate.files.logs.canopen_words import SDO_ANSWER, SDO_REQUEST

if TYPE_CHECKING:
    from collections.abc import Callable

    from canopen import Network
    from canopen.objectdictionary import ObjectDictionary

MAX_RESPONSES = 64  # of one transfer: no object that is read here is longer
SEGMENTS = frozenset({0x00, 0x20})  # answers that name no object
UPLOADED, DOWNLOADED = 0x40, 0x60  # answers to the first request of a reading and of a writing
NO_OBJECT = bytes(3)  # in some devices' aborts


class PumpedSdoClient(SdoClient):
    """An SDO client that reads the bus itself while it waits for an answer.

    It does so in the thread that made it. In any other thread it waits until the first one reads the bus.
    Late answers about another object, or to a writing while the object is read, are dropped; canopen takes
    them for the answer to its last request.

    Args:
        node: CANopen node id of the server.
        dictionary: Object dictionary of the node.
        network: Network that sends the requests.
        pump: Reads and handles one frame, waiting for it at most so many seconds.

    Attributes:
        most_responses: How many answers are accepted in one transfer.
        responses_left: How many answers are still accepted in the current transfer.
        object: Index and sub-index of the current transfer as they stand in a frame, 3 bytes.
        second_answers: Answers to requests that had been answered, since the last `count_anew`.
    """

    def __init__(
        self, node: int, dictionary: ObjectDictionary, network: Network, pump: Callable[[float], None]
    ) -> None:
        super().__init__(SDO_REQUEST + node, SDO_ANSWER + node, dictionary)  # type: ignore[no-untyped-call]  # canopen
        self.network = network
        self._pump = pump
        self._thread = threading.get_ident()
        self.most_responses = self.responses_left = MAX_RESPONSES
        self.object = b""
        self._not_awaited = DOWNLOADED
        self.second_answers = 0
        self._answered: set[bytes] = set()  # objects that were asked for once, and answered
        self._asked: set[bytes] = set()
        self._repeated: set[bytes] = set()

    def count_anew(self) -> None:
        """Count second answers from zero; requests that are repeated from now on may have two."""
        self.second_answers = 0
        for objects in (self._asked, self._answered, self._repeated):
            objects.clear()

    def begin(self, index: int, subindex: int, *, is_write: bool = False) -> None:
        """Expect answers about one object from now on, at most `most_responses`."""
        self.responses_left = self.most_responses
        self.object = index.to_bytes(2, "little") + bytes((subindex,))
        self._not_awaited = UPLOADED if is_write else DOWNLOADED
        if self.object in self._asked:
            self._repeated.add(self.object)
        self._asked.add(self.object)

    def on_response(self, can_id: int, data: bytes | bytearray, timestamp: float) -> None:
        """Take an answer of 8 bytes, unless it is a late one about another request."""
        kind, about = data[0] & 0xE0, bytes(data[1:4])
        if kind not in SEGMENTS and about in self._answered - self._repeated:
            self.second_answers += 1
        elif about == self.object:
            self._answered.add(about)
        if kind in SEGMENTS or (kind != self._not_awaited and about in {self.object, NO_OBJECT}):
            super().on_response(can_id, data, timestamp)  # type: ignore[no-untyped-call]  # canopen

    def read_response(self) -> bytes:
        """Return the next answer.

        Raises:
            SdoAbortedError: The node refuses.
            SdoCommunicationError: The node does not answer in time, or does not stop answering.
        """
        self.responses_left -= 1
        if self.responses_left < 0:
            raise SdoCommunicationError("the answer does not end")
        if threading.get_ident() == self._thread:
            end = time.monotonic() + self.RESPONSE_TIMEOUT
            while self.responses.empty():
                left = end - time.monotonic()
                self._pump(max(0.0, left))
                if left <= 0.0 and self.responses.empty():
                    raise SdoCommunicationError("no answer")
        return super().read_response()  # type: ignore[no-any-return, no-untyped-call]  # canopen
