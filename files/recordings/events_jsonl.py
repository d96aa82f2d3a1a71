"""`events.jsonl`: what the driver knew while a recording was made, one JSON object a line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Literal, NamedTuple

from omnimate.vehicle.atomic import write_text
from omnimate.vehicle.errors import RecordingError, describe_read_error

if TYPE_CHECKING:
    from collections.abc import Iterable

EVENTS = "events.jsonl"


class RecordedEvent(NamedTuple):
    """An event of the driver, at each time at which it happened.

    Times are on the recording's clock [s]; the node is None where it concerns the bus. A fault stops the
    robot or loses a node or the bus; a command is one of wheel speeds.
    """

    time: float
    node: int | None
    what: str
    kind: Literal["event", "fault", "command"] = "event"


def read_events(path: Path | str) -> tuple[RecordedEvent, ...]:
    """Return the events of an `events.jsonl` in the order of their times.

    Raises:
        RecordingError: The file cannot be read, or a line is no event; the error names file and line.
    """
    try:
        lines = Path(path).read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise RecordingError(path, f"cannot be read: {describe_read_error(error)}") from error
    events = [_event(line, f"{path}:{number}") for number, line in enumerate(lines, start=1)]
    return tuple(sorted(events, key=lambda event: event.time))


def write_events(events: Iterable[RecordedEvent], path: Path) -> None:
    """Write an `events.jsonl` atomically, in the order of the times."""
    ordered = sorted(events, key=lambda event: event.time)
    write_text(path, "".join(f"{json.dumps(event._asdict())}\n" for event in ordered))


def _event(line: str, place: str) -> RecordedEvent:
    try:
        event = RecordedEvent(**json.loads(line))
        return event._replace(time=float(event.time))
    except (ValueError, TypeError, OverflowError, RecursionError) as error:
        raise RecordingError(place, f"expected an object with time, node, what and kind: {error}") from error
