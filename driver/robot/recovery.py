"""Configures nodes again that have lost their configuration, while SYNC goes on."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from typing import TYPE_CHECKING

from omnimate.driver.errors import BusLost, DriverError

if TYPE_CHECKING:
    from collections.abc import Callable

    from omnimate.driver.canopen.node_setup import NodeConfiguration
    from omnimate.driver.robot.events import EventLog

FIRST_DELAY, LONGEST_DELAY = 0.25, 5.0  # [s] before a failed configuration is tried again, doubled each time


class Recovery:
    """A queue of nodes to configure, one at a time.

    Where time stands still between two SYNCs the SDO dialogue runs in between. Otherwise it runs in a thread,
    which gets its answers from the driver's reading of the bus, so that no SYNC is late.
    """

    def __init__(
        self, configure: Callable[[int], NodeConfiguration], events: EventLog, *, inline: bool
    ) -> None:
        self._configure = configure
        self._events = events
        self._inline = inline
        self._waiting: dict[int, tuple[float, float]] = {}  # node id: time when it is due, next delay [s]
        self._job: tuple[int, float, Future[NodeConfiguration]] | None = None  # node, next delay, result
        self._executor: ThreadPoolExecutor | None = None

    @property
    def is_busy(self) -> bool:
        """Whether a node still waits for its configuration."""
        return bool(self._waiting) or self._job is not None

    def is_waiting(self, node: int) -> bool:
        """Return whether a node waits for its configuration, or is being configured."""
        return node in self._waiting or (self._job is not None and self._job[0] == node)

    def request(self, node: int, now: float) -> None:
        """Queue a node, which is due at time `now` [s]; one that is being configured is configured again."""
        self._waiting[node] = (now, FIRST_DELAY)

    def poll(self, now: float) -> NodeConfiguration | None:
        """Begin or end a dialogue, once per SYNC at time `now` [s]; return a new configuration, if any.

        Raises BusLost in a dialogue between two SYNCs.
        """
        if self._job is None:
            node = next((node for node, (due, _) in self._waiting.items() if due <= now), None)
            if node is None:
                return None
            _, delay = self._waiting.pop(node)
            if self._inline:
                return self._finish(node, delay, partial(self._configure, node), now)
            if self._executor is None:
                self._executor = ThreadPoolExecutor(max_workers=1, thread_name_prefix="configure")
            self._job = (node, delay, self._executor.submit(self._configure, node))
        node, delay, future = self._job
        if not future.done():
            return None
        self._job = None
        return self._finish(node, delay, future.result, now)

    def close(self) -> None:
        """Wait until the current dialogue ends; its SDO time-outs limit the wait."""
        if self._executor is not None:
            self._executor.shutdown(wait=True, cancel_futures=True)

    def _finish(
        self, node: int, delay: float, result: Callable[[], NodeConfiguration], now: float
    ) -> NodeConfiguration | None:
        """Return the result of a dialogue; where it failed, log that and try again later."""
        try:
            return result()
        except BusLost:
            if self._inline:
                raise
            problem = "the bus was lost"
        except DriverError as error:
            problem = str(error)
        self._events.add(now, node, f"could not be configured again, tried until it can: {problem}")
        self._waiting.setdefault(node, (now + delay, min(2.0 * delay, LONGEST_DELAY)))
        return None
