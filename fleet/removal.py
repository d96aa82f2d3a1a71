"""Removal of a recording from a store, with all that came of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.files.recordings.folder import VEHICLE
from omnimate.fleet.batch.work import result_paths
from omnimate.fleet.report_store import delete_history_day, delete_report

if TYPE_CHECKING:
    from omnimate.fleet.batch.files import Files
    from omnimate.fleet.batch.store import StoredRecording


def delete_recording(store: Files, results: Files, stored: StoredRecording) -> bool:
    """Delete a recording and its results; return whether there was anything of it.

    The daily report of its day goes where no other recording of that day has results, and the day goes from
    the robot's history where no other one of the robot has. What is left of an interrupted deletion goes by
    the next one.

    Raises:
        OSError: Files cannot be read or written.
    """
    files = store.glob(f"{stored.partition}/{stored.name}/*")
    tables = result_paths(results, stored)
    # A recording without vehicle.toml is none, so that no batch takes up a part of one.
    for path in sorted(files, key=lambda path: not path.endswith(VEHICLE)):
        store.delete(path)
    for path in tables:
        results.delete(path)
    if not results.glob(f"recordings/{stored.partition}/*.parquet"):
        delete_history_day(results, stored.robot, stored.day)
    if not results.glob(f"recordings/robot=*/day={stored.day}/*.parquet"):
        delete_report(results, stored.day)
    return bool(files or tables)
