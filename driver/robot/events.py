"""Events of nodes and bus, troubles that stop the robot, and frame counters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

MAX_EVENTS = 2000  # in a log, so that its memory is bounded


@dataclass(frozen=True, slots=True)
class Event:
    """An event of a node or the bus, for an operator.

    Attributes:
        time: Time at which it first happened, on the recording's clock [s].
        last: Time at which it last happened, on the recording's clock [s].
        count: How often it happened.
        node: CANopen node id; None where it concerns the bus.
        what: Description of the event.
        is_problem: Whether somebody must put it right before the data can be trusted.
    """

    time: float
    last: float
    count: int
    node: int | None
    what: str
    is_problem: bool = False


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
    """How many frames of one node were received, and what was wrong with them.

    Attributes:
        received: PDOs that entered a sample.
        missing: SYNCs that a PDO of the node did not answer in time.
        late: PDOs that came after their sample was closed.
        duplicate: Second answers to one SYNC.
        wrong_length: PDOs, heartbeats or EMCYs of an impossible length.
        unknown: Frames of this node that nothing expects.
        jumps: Readings that no robot can make.
    """

    received: int = 0
    missing: int = 0
    late: int = 0
    duplicate: int = 0
    wrong_length: int = 0
    unknown: int = 0
    jumps: int = 0


@dataclass(frozen=True, slots=True)
class Trouble:
    """A node, or the bus, that is not as it must be.

    Attributes:
        time: When it was noticed, on the recording's clock [s].
        node: CANopen node id; None where it concerns the bus.
        what: Description of the trouble.
        has_restarted: Whether the node may have lost its configuration.
        emergency: Error code of the EMCY frame that reported it; None for any other cause.
        status: Status word 6041h with which a drive left operation enabled; None for any other cause.
    """

    time: float
    node: int | None
    what: str
    has_restarted: bool = False
    emergency: int | None = None
    status: int | None = None
