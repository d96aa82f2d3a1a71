"""Configures nodes again that have lost their configuration, while SYNC goes on."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.driver.errors import BusLost, DriverError

if TYPE_CHECKING:
    from collections.abc import Callable

    from omnimate.driver.canopen.node_setup import NodeConfiguration
    from omnimate.driver.robot.events import EventLog

FIRST_DELAY, LONGEST_DELAY = 0.25, 30.0  # [s] before a failed configuration is tried again


@dataclass(slots=True)
class _Waiting:
    due: float
    delay: float


class Recovery:
    """A queue of nodes to configure, one at a time.

    Where time stands still between two SYNCs the SDO dialogue is held in between. Otherwise it is held in a
    thread, which gets its answers from the driver's reading of the bus, so that no SYNC is late.

    Args:
        configure: Configures a node and returns what was read and changed.
        events: Log for failures.
        inline: Whether time stands still between two SYNCs.
    """

    def __init__(
        self, configure: Callable[[int], NodeConfiguration], events: EventLog, *, inline: bool
    ) -> None:
        self._configure = configure
        self._events = events
        self._inline = inline
        self._waiting: dict[int, _Waiting] = {}
        self._job: tuple[int, Future[NodeConfiguration]] | None = None
        self._executor: ThreadPoolExecutor | None = None

    @property
    def is_busy(self) -> bool:
        """Whether a node still waits for its configuration."""
        return bool(self._waiting) or self._job is not None

    def request(self, node: int, now: float) -> None:
        """Have a node configured as soon as possible, from time `now` [s] on."""
        self._waiting[node] = _Waiting(now, FIRST_DELAY)

    def poll(self, now: float) -> NodeConfiguration | None:
        """Go on without waiting, once per SYNC at time `now` [s]; return a finished configuration, if any.

        Raises:
            BusLost: The interface failed in a dialogue that was held inline.
        """
        if self._job is None:
            self._begin(now)
        if self._job is None or not self._job[1].done():
            return None
        node, future = self._job
        self._job = None
        return self._finish(node, future, now)

    def close(self) -> None:
        """Wait for the dialogue that is going on; its SDO time-outs limit the wait."""
        if self._executor is not None:
            self._executor.shutdown(wait=True, cancel_futures=True)

    def _begin(self, now: float) -> None:
        node = next((node for node, waiting in self._waiting.items() if waiting.due <= now), None)
        if node is None:
            return
        if self._inline:
            self._job = (node, _run(self._configure, node))
            return
        if self._executor is None:
            self._executor = ThreadPoolExecutor(max_workers=1, thread_name_prefix="configure")
        self._job = (node, self._executor.submit(self._configure, node))

    def _finish(self, node: int, future: Future[NodeConfiguration], now: float) -> NodeConfiguration | None:
        try:
            done = future.result()
        except BusLost:
            if self._inline:
                raise
            self._again(node, now, "the bus was lost")
        except DriverError as error:
            self._again(node, now, str(error))
        else:
            self._waiting.pop(node, None)
            return done
        return None

    def _again(self, node: int, now: float, problem: str) -> None:
        waiting = self._waiting[node]
        self._events.add(now, node, f"could not be configured again, tried until it can: {problem}")
        self._waiting[node] = _Waiting(now + waiting.delay, min(2.0 * waiting.delay, LONGEST_DELAY))


def _run(configure: Callable[[int], NodeConfiguration], node: int) -> Future[NodeConfiguration]:
    future: Future[NodeConfiguration] = Future()
    try:
        future.set_result(configure(node))
    except DriverError as error:
        future.set_exception(error)
    return future
