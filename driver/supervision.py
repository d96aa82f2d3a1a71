"""NMT states, heartbeats, emergencies and restarts of the nodes, on the driver's clock."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from vehicle.canopen_words import emcy_in_words, nmt_state_in_words

if TYPE_CHECKING:
    from collections.abc import Iterable

    from driver.events import EventLog

BOOT_UP, OPERATIONAL = 0x00, 0x05
FAULT_MASK, FAULT = 0x4F, 0x08  # of the status word, CiA 402
LOST_AFTER = 3.0  # heartbeat periods
NOT_OPERATIONAL_AFTER = 2  # heartbeats in a row: one may have been on its way while NMT start was sent


@dataclass(slots=True)
class NodeState:
    """What is known of a node.

    Attributes:
        node: CANopen node id.
        state: of its last heartbeat; None before the first.
        timeout: after which its heartbeat is lost [s]; None where it has none.
        heard: time of its last heartbeat [s]; None before the first, from which on it is supervised.
        is_lost: its heartbeat is overdue.
        is_running: it was started, so that any other state than operational is a loss.
        wrong_states: heartbeats in a row that did not say operational.
        heartbeats: received.
        emergencies: received.
        boots: boot-up frames received.
        restarts: boot-ups and losses of its configuration while it was running.
    """

    node: int
    state: int | None = None
    timeout: float | None = None
    heard: float | None = None
    is_lost: bool = False
    is_running: bool = False
    wrong_states: int = 0
    heartbeats: int = 0
    emergencies: int = 0
    boots: int = 0
    restarts: int = 0


class Supervision:
    """Follows every node of the vehicle; what needs a reaction stands in `restarted`.

    Attributes:
        nodes: by node id.
        restarted: nodes that have lost their configuration and wait for the driver to give it again.
        lost: nodes whose heartbeat has just been lost, or that report a drive fault, likewise.
        status_words: COB-IDs of TPDOs that begin with a drive's status word, and their nodes.
    """

    def __init__(self, nodes: Iterable[int], events: EventLog) -> None:
        self.nodes = {node: NodeState(node) for node in nodes}
        self.restarted: set[int] = set()
        self.lost: set[int] = set()
        self.status_words: dict[int, int] = {}
        self._events = events

    def started(self, node: int, heartbeat: float | None) -> None:
        """Expect a node to be operational from now on, with a heartbeat period [s]."""
        state = self.nodes[node]
        state.is_running, state.wrong_states, state.heard = True, 0, None
        state.timeout = None if not heartbeat else LOST_AFTER * heartbeat

    def heartbeat(self, node: int, data: bytes | bytearray, now: float) -> bool:
        """Take a heartbeat or boot-up frame; return False where it is none."""
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
        state.heard = now
        return True

    def emergency(self, node: int, data: bytes | bytearray, now: float) -> bool:
        """Take an EMCY frame; return False where it is none."""
        if len(data) != 8:
            return False
        code, register = int.from_bytes(data[:2], "little"), data[2]
        self.nodes[node].emergencies += 1
        self._events.add(
            now, node, f"EMCY {code:04X}h: {emcy_in_words(code)} (error register {register:02X}h)"
        )
        return True

    def status_word(self, cob_id: int, data: bytes | bytearray, now: float) -> None:
        """Take a TPDO that begins with the status word 6041h of a CiA 402 drive."""
        status = int.from_bytes(data[:2], "little")
        if len(data) >= 2 and status & FAULT_MASK == FAULT:
            node = self.status_words[cob_id]
            self.lost.add(node)
            self._events.add(now, node, f"the drive reports a fault (status word {status:04X}h)")

    def check(self, now: float) -> None:
        """Find the nodes whose heartbeat is overdue at a time [s]."""
        for state in self.nodes.values():
            if not state.is_running or state.timeout is None or state.heard is None or state.is_lost:
                continue
            if now - state.heard > state.timeout:
                state.is_lost = True
                self.lost.add(state.node)
                self._events.add(now, state.node, f"heartbeat lost: none for {state.timeout:g} s")

    def pause(self, seconds: float) -> None:
        """Do not hold a time against the nodes in which the bus was not heard [s]."""
        for state in self.nodes.values():
            if state.heard is not None:
                state.heard += seconds

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
            self.restarted.add(state.node)
            self._events.add(now, state.node, what)
