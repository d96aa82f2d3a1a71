"""NMT states, heartbeats, emergencies and restarts of the nodes, on the driver's clock."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.driver.robot.events import Trouble
from omnimate.files.logs.canopen_words import BOOT_UP, OPERATIONAL, emergency_in_words, nmt_state_in_words

if TYPE_CHECKING:
    from collections.abc import Iterable

    from omnimate.driver.robot.events import EventLog

NO_ERROR = 0x0000  # emergency error code: error reset (CiA 301, 7.2.7)
LOST_AFTER = 3.0  # heartbeat periods: a drive with 25 ms is lost after 75 ms, before 100 ms have passed
NOT_OPERATIONAL_AFTER = 2  # heartbeats in a row: one may be in transit while NMT start is sent


@dataclass(slots=True)
class NodeState:
    """The state of a node."""

    node: int  # CANopen node id
    state: int | None = None  # NMT state in its last heartbeat; None before the first
    timeout: float | None = None  # time after which its heartbeat is lost [s]; None where it has none
    # time of its last heartbeat [s]; None before the first, from which on it is supervised
    last_heartbeat: float | None = None
    is_lost: bool = False  # whether its heartbeat is overdue
    is_running: bool = False  # whether it was started, so that any other state than operational is a loss
    wrong_states: int = 0  # heartbeats in a row with another state than operational
    heartbeats: int = 0  # number of heartbeats received
    emergencies: int = 0  # number of EMCY frames received
    boots: int = 0  # number of boot-up frames received
    known_boots: int = 0  # boot-up frames received before the driver last took it out of operation
    restarts: int = 0  # number of boot-ups and losses of its configuration while it was running


class Supervision:
    """Tracks the state of every node of the vehicle, by node id.

    `troubles` are emergencies, lost heartbeats and restarts, until the driver has reacted.
    """

    def __init__(self, nodes: Iterable[int], events: EventLog) -> None:
        self.nodes = {node: NodeState(node) for node in nodes}
        self.troubles: list[Trouble] = []
        self._events = events

    def started(self, node: int, heartbeat: float | None) -> None:
        """Expect a node to be operational from now on, with a heartbeat period [s], None for no heartbeat."""
        state = self.nodes[node]
        state.is_running, state.wrong_states, state.last_heartbeat = True, 0, None
        state.timeout = None if not heartbeat else LOST_AFTER * heartbeat

    def interrupted(self, node: int) -> None:
        """Expect that a node leaves operation from now on, because the driver configures it."""
        state = self.nodes[node]
        state.is_running, state.known_boots = False, state.boots

    def check_boots(self, node: int, now: float) -> None:
        """Report at `now` [s] a node that has booted since `interrupted`, though it was started again."""
        state = self.nodes[node]
        if state.boots != state.known_boots:
            self._restarted(state, now, "restarted (boot-up) while it was configured")

    def heartbeat(self, node: int, data: bytes | bytearray, now: float) -> bool:
        """Take a heartbeat or boot-up frame at `now` [s]; return False where its length is impossible."""
        if len(data) != 1:
            return False
        state = self.nodes[node]
        state.state = data[0] & 0x7F
        state.heartbeats += 1
        if state.is_lost:
            state.is_lost = False
            self._events.add(now, node, "heartbeat is back")
        if state.state == BOOT_UP:
            state.boots += 1
            self._restarted(state, now, "restarted (boot-up)")
        elif state.is_running:
            self._check_state(state, now)
        state.last_heartbeat = now
        return True

    def emergency(self, node: int, data: bytes | bytearray, now: float) -> bool:
        """Take an EMCY frame at time `now` [s]; return False where its length is impossible."""
        if len(data) != 8:
            return False
        code, what = int.from_bytes(data[:2], "little"), emergency_in_words(data)
        self.nodes[node].emergencies += 1
        self._events.add(now, node, what)
        if code != NO_ERROR:
            self.troubles.append(Trouble(now, node, what, emergency=code))
        return True

    def check(self, now: float) -> None:
        """Report the nodes whose heartbeat is overdue at time `now` [s]."""
        for state in self.nodes.values():
            if not state.is_running or state.timeout is None or state.last_heartbeat is None or state.is_lost:
                continue
            if now - state.last_heartbeat > state.timeout:
                state.is_lost = True
                self._report(now, state.node, f"heartbeat lost: none for {state.timeout:g} s")

    def pause(self, seconds: float, now: float) -> None:
        """Exclude a time until `now` [s], in which the bus was not read, from the time without heartbeats."""
        for state in self.nodes.values():
            if state.last_heartbeat is not None:
                state.last_heartbeat = min(state.last_heartbeat + seconds, now)

    def _check_state(self, state: NodeState, now: float) -> None:
        if state.state == OPERATIONAL:
            state.wrong_states = 0
            return
        state.wrong_states += 1
        if state.wrong_states == NOT_OPERATIONAL_AFTER:
            assert state.state is not None  # the caller has set it
            words = nmt_state_in_words(state.state)
            self._restarted(state, now, f"is {words}, expected operational: it has lost its configuration")

    def _restarted(self, state: NodeState, now: float, what: str) -> None:
        if state.is_running:
            state.restarts += 1
            state.is_running = False
            self._report(now, state.node, what, has_restarted=True)

    def _report(self, now: float, node: int, what: str, *, has_restarted: bool = False) -> None:
        self._events.add(now, node, what, is_fault=True)
        self.troubles.append(Trouble(now, node, what, has_restarted))
