"""Events of nodes and bus, troubles that stop the robot, and frame counters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

MAX_EVENTS = 2000  # in a log, so that its memory is bounded


@dataclass(frozen=True, slots=True)
class Event:
    """An event of a node or the bus, for an operator."""

    time: float  # time at which it first happened, on the recording's clock [s]
    last: float  # time at which it last happened, on the recording's clock [s]
    count: int  # how often it happened
    node: int | None  # CANopen node id; None where it concerns the bus
    what: str  # description of the event
    is_problem: bool = False  # whether somebody must put it right before the data can be trusted


class EventListener(Protocol):
    """What is called with each event, also where the log only counts it."""

    def __call__(self, time: float, node: int | None, what: str, *, is_fault: bool) -> None:
        """Take an event; the arguments are those of `EventLog.add`."""
        ...


class EventLog:
    """A bounded log of events in order; the same words about the same node are one event that counts.

    What does not fit is counted in `dropped`; the `listener` is called with each event all the same.
    """

    def __init__(self) -> None:
        self.dropped = 0
        self.listener: EventListener | None = None
        self._events: dict[tuple[int | None, str], Event] = {}

    def add(
        self, time: float, node: int | None, what: str, *, is_problem: bool = False, is_fault: bool = False
    ) -> None:
        """Add an event of a node, None for the bus, at `time` [s]; beyond `MAX_EVENTS` it is only counted.

        A problem must be put right before the data can be trusted. A fault stops the robot, or a node or the
        bus is lost; a problem is a fault, too.
        """
        if self.listener is not None:
            self.listener(time, node, what, is_fault=is_fault or is_problem)
        key = (node, what)
        known = self._events.get(key)
        if known is not None:
            self._events[key] = Event(known.time, time, known.count + 1, node, what, is_problem)
        elif len(self._events) < MAX_EVENTS:
            self._events[key] = Event(time, time, 1, node, what, is_problem)
        else:
            self.dropped += 1

    def unrecorded(self, at: float, error: OSError) -> None:
        """Count a frame at a time [s] that could not be recorded: all of them are one event."""
        what = f"recording: {error.strerror or error}; frames are missing from it"
        self.add(at, None, what, is_problem=True)

    def all(self) -> tuple[Event, ...]:
        """Return the events in order of their first time."""
        return tuple(sorted(self._events.values(), key=lambda event: event.time))


@dataclass(slots=True)
class NodeCounts:
    """How many frames of one node were received, and what was wrong with them."""

    received: int = 0  # PDOs that entered a sample
    missing: int = 0  # SYNCs that a PDO of the node did not answer in time
    late: int = 0  # PDOs that came after their sample was closed
    duplicate: int = 0  # second answers to one SYNC
    wrong_length: int = 0  # PDOs, heartbeats or EMCYs of an impossible length
    unknown: int = 0  # frames of this node that nothing expects
    jumps: int = 0  # readings that no robot can make


@dataclass(frozen=True, slots=True)
class Trouble:
    """A node, or the bus, that is not as it must be."""

    time: float  # when it was noticed, on the recording's clock [s]
    node: int | None  # CANopen node id; None where it concerns the bus
    what: str  # description of the trouble
    has_restarted: bool = False  # whether the node may have lost its configuration
    emergency: int | None = None  # error code of the EMCY frame that reported it; None for any other cause
    # status word 6041h with which a drive left operation enabled; None for any other cause
    status: int | None = None
