"""What happened and when: a bounded log in which repetitions are counted, not repeated."""

from __future__ import annotations

from dataclasses import dataclass

MAX_EVENTS = 2000


@dataclass(frozen=True, slots=True)
class Event:
    """Something that an operator should know.

    Attributes:
        time: Time at which it first happened, on the recording's clock [s].
        last: Time at which it last happened, on the recording's clock [s].
        count: How often it happened.
        node: CANopen node id; None where it concerns the bus.
        what: What happened, in words.
        is_problem: Whether somebody must put it right before the data can be trusted.
    """

    time: float
    last: float
    count: int
    node: int | None
    what: str
    is_problem: bool = False


class EventLog:
    """Events in order; the same words about the same node are one event that counts.

    Attributes:
        dropped: Number of events that were not kept because the log was full.
    """

    def __init__(self) -> None:
        self.dropped = 0
        self._events: dict[tuple[int | None, str], Event] = {}

    def add(self, time: float, node: int | None, what: str, *, is_problem: bool = False) -> None:
        """Add an event; beyond `MAX_EVENTS` it is only counted in `dropped`.

        Args:
            time: Time of the event on the recording's clock [s].
            node: CANopen node id; None where it concerns the bus.
            what: What happened, in words.
            is_problem: Whether somebody must put it right before the data can be trusted.
        """
        key = (node, what)
        known = self._events.get(key)
        if known is not None:
            self._events[key] = Event(known.time, time, known.count + 1, node, what, is_problem)
        elif len(self._events) < MAX_EVENTS:
            self._events[key] = Event(time, time, 1, node, what, is_problem)
        else:
            self.dropped += 1

    def all(self) -> tuple[Event, ...]:
        """Return the events in order of their first time."""
        return tuple(sorted(self._events.values(), key=lambda event: event.time))
