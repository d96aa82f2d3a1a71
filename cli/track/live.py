"""Tracking sample by sample: rows as CSV or JSON lines, a status line, disturbances and frozen channels."""

from __future__ import annotations

import contextlib
import csv
import json
import math
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from omnimate.cli.console import note, warn
from omnimate.cli.errors import CallError
from omnimate.cli.following import follow
from omnimate.cli.track.words import disturbance_in_words, frozen_in_words, row_in_words

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from omnimate.ipec.tracker import OneTruckTracker, Row, Tracker
    from omnimate.vehicle.sample import Sample

CHECK_PERIOD = 5.0  # [s] between two checks for frozen channels


@dataclass
class RowWriter:
    """Writes each row to the files that were asked for, and flushes it, so that others can follow.

    Either file may be None, where none is wanted; `leaves_stdout`: standard output is free for words.
    """

    csv_file: TextIO | None
    json_file: TextIO | None
    leaves_stdout: bool
    _has_head: bool = field(default=False, init=False)

    def write(self, row: Row) -> None:
        """Write one row."""
        values = row.as_dict()
        if self.json_file is not None:
            self.json_file.write(json.dumps(values, allow_nan=False) + "\n")
            self.json_file.flush()
        if self.csv_file is None:
            return
        table = csv.writer(self.csv_file, lineterminator="\n")
        if not self._has_head:
            table.writerow(values)
            self._has_head = True
        table.writerow("" if value is None else repr(value) for value in values.values())
        self.csv_file.flush()


@contextlib.contextmanager
def open_rows(csv_path: Path | None, jsonl: str | None) -> Iterator[RowWriter]:
    """Open the files of rows; `-` is standard output.

    Raises:
        CallError: One of them cannot be written.
    """
    with contextlib.ExitStack() as stack:
        table = stack.enter_context(_create(csv_path)) if csv_path is not None else None
        lines: TextIO | None = None
        if jsonl is not None:
            lines = sys.stdout if jsonl == "-" else stack.enter_context(_create(Path(jsonl)))
        yield RowWriter(table, lines, leaves_stdout=jsonl != "-")


def _create(path: Path) -> TextIO:
    try:
        return path.open("w", encoding="utf-8", newline="")
    except OSError as error:
        raise CallError(f"{path}: cannot be written: {error.strerror}; choose another file") from error


def follow_robot(
    samples: Iterable[Sample],
    tracker: Tracker | OneTruckTracker,
    writer: RowWriter,
    *,
    seconds: float | None,
    every: float,
) -> None:
    """Track samples until the time is up, the source ends or Ctrl-C; write rows, report disturbances.

    A row is written every `every` seconds.
    """
    first: float | None = None
    written, checked = -math.inf, 0.0
    reported: set[str] = set()
    followed = follow(samples, seconds, lambda last, passed: row_in_words(tracker.look(), last.time - passed))
    with contextlib.closing(followed):
        for sample in followed:
            tracker.step(sample)
            if first is None:
                first = checked = sample.time
            if sample.time - written >= every - 1e-9:
                written = sample.time
                writer.write(tracker.row())
            for disturbance in tracker.take_disturbances():
                note(disturbance_in_words(disturbance, first, tracker.vehicle))
            if sample.time - checked >= CHECK_PERIOD:
                checked = sample.time
                _report_frozen(tracker, reported)


def _report_frozen(tracker: Tracker | OneTruckTracker, reported: set[str]) -> None:
    """Warn of each frozen channel once."""
    for frozen in tracker.frozen():
        if frozen.channel not in reported:
            reported.add(frozen.channel)
            warn(frozen_in_words(frozen, tracker.vehicle))
