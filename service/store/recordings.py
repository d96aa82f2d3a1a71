"""Recordings are files, those of sessions and those of fleets; the database says which there are.

They are read in a separate process, whose memory and time are limited.
"""

from __future__ import annotations

import hashlib
import math
import os
import secrets
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

from sqlalchemy import delete, select

from omnimate.files.recordings.folder import VEHICLE, read_recording
from omnimate.fleet.batch.files import open_files
from omnimate.service.errors import InvalidValueError, NotFoundError, TooLargeError
from omnimate.service.jobs.process import running
from omnimate.service.recording_zip import unpack
from omnimate.service.store.tables import RecordingContentRow, RecordingFileRow, RecordingRow
from omnimate.service.store.vehicles import require_name
from omnimate.vehicle.errors import OmnimateError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from omnimate.fleet.batch.files import Files
    from omnimate.ipec.tracker import Learned
    from omnimate.service.store.database import Database
    from omnimate.vehicle.recording import Recording

FOLDER = "_recordings"  # no fleet's: their names begin with a letter or a digit
DAY = 86400.0  # [s]
MEMORY_LIMIT = 2_000_000_000  # [bytes]; 5 million frames take half of it
MAX_PROBLEMS = 20  # of a log that are kept
MAX_PROBLEM_LENGTH = 300  # characters
READ_TIMEOUT = 120.0  # [s]; 5 million frames take 4 s
CHECK_PERIOD = 5.0  # [s]: whoever may ask whether the service is ready must not keep the disk busy
CHECK_WAIT = 1.0  # [s] for the database's lock: what asks whether the service is ready waits a few seconds
CHECK_SIZE = 4096  # [bytes], a block of most file systems
T = TypeVar("T")


def summarize(recording: Recording) -> dict[str, Any]:
    """Return the columns of a recording's row that describe its content."""
    return {
        "vehicle": recording.vehicle.name[:100],
        "samples": len(recording),
        "seconds": float(recording.time[-1] - recording.time[0]),
        "laps": 0 if recording.run is None else len(recording.run.laps),
        "poses": 0 if recording.poses is None else len(recording.poses.time),
    }


def summarize_upload(recording: Recording) -> dict[str, Any]:
    """Return the same of a recording whose robot the service could store; InvalidValueError of another."""
    require_name(recording.vehicle, f"{VEHICLE}: name")
    return summarize(recording)


def learned_by(recording: Recording, *, uncalibrated: bool) -> Learned:
    """Return the robot, and what the filter has learned of it by the end of a recording.

    More of an uncalibrated robot, which is described by nominal values, may be wrong.

    Raises:
        NoLinkageError: the robot has a single truck.
        LinkageChannelError: a channel of the linkage was never read, or stood still while it must move.
    """
    from omnimate.ipec.filter.estimate import estimate
    from omnimate.ipec.filter.prior import CALIBRATED, NOMINAL

    last = estimate(recording, prior=NOMINAL if uncalibrated else CALIBRATED)
    return recording.vehicle, last.slow, last.findings


class RecordingStore:
    """The recordings that were uploaded, or driven for a session: one zip each, of limited size [bytes].

    A file is written before its row is committed, and deleted after its row: a row always has its file.
    """

    def __init__(self, database: Database, root: str, limit: int) -> None:
        self._database, self._limit = database, limit
        self._files = open_files(f"{root.rstrip('/')}/{FOLDER}")
        self._checked = -math.inf  # time of the last success of `check`

    def add(self, name: str, content: bytes, summary: dict[str, Any]) -> RecordingRow:
        """Write a recording's zip; return the row, which the caller adds to the database."""
        row = RecordingRow(
            id=secrets.token_hex(8),
            name=name,
            size=len(content),
            sha256=hashlib.sha256(content).hexdigest(),
            created=time.time(),
            **summary,
        )
        with self._database.writing() as db:
            db.add(RecordingFileRow(id=row.id, created=row.created))
        self._files.write(f"{row.id}.zip", content)
        return row

    def add_upload(self, name: str, content: bytes) -> RecordingRow:
        """Write an uploaded zip after its recording was read completely; return its row.

        Raises:
            MediaTypeError: the content is not a zip.
            InvalidValueError: the zip is not one of a recording folder, or the recording cannot be read.
            TooLargeError: the recording is too large when it is unpacked or read.
        """
        summary, problems = self._read(content, name, summarize_upload)
        return self.add(name, content, summary | {"problems": problems})

    def read(self, row: RecordingRow, extract: Callable[[Recording], T]) -> T:
        """Return what a function takes from a recording; raises as `content` and `read_in_process`."""
        return self._read(self.content(row), row.name, extract)[0]

    def _read(self, content: bytes, name: str, extract: Callable[[Recording], T]) -> tuple[T, list[str]]:
        with tempfile.TemporaryDirectory() as place:
            folder = unpack(content, Path(place) / "zip", self._limit)
            return read_in_process(Path(place), folder, name, extract)

    def content(self, row: RecordingRow) -> bytes:
        """Return the zip of a recording; NotFoundError where the recording was deleted meanwhile."""
        try:
            return self._files.read(f"{row.id}.zip")
        except FileNotFoundError as error:
            raise NotFoundError("recording", row.id) from error

    def unpack(self, row: RecordingRow, folder: Path) -> Path:
        """Unpack a recording into an empty folder; NotFoundError where it was deleted meanwhile."""
        return unpack(self.content(row), folder, self._limit)

    def delete(self, recording_id: str) -> None:
        """Delete the file of a recording whose row is deleted."""
        self._files.delete(f"{recording_id}.zip")

    def check(self) -> None:
        """Check that a recording could be stored, by the writes of an upload; a success holds `CHECK_PERIOD`.

        Raises:
            SQLAlchemyError: the database cannot be written.
            OSError: no file can be written, on a full disk for instance.
        """
        if time.monotonic() < self._checked + CHECK_PERIOD:
            return
        probe = secrets.token_hex(8)
        with self._database.writing(CHECK_WAIT) as db:
            db.add(RecordingFileRow(id=probe, created=time.time()))
        try:
            self._files.write(f"{probe}.zip", bytes(CHECK_SIZE))
            self.delete(probe)
        finally:
            with self._database.writing(CHECK_WAIT) as db:
                db.execute(delete(RecordingFileRow).where(RecordingFileRow.id == probe))
        self._checked = time.monotonic()

    def delete_orphans(self, now: float) -> None:
        """Delete files that for a day have had no recording, since the service died between both writes.

        Only files that this database names are deleted: services of other databases may use the folder, too.
        """
        with self._database.reading() as db:
            ids = db.scalars(select(RecordingFileRow.id).where(RecordingFileRow.created < now - DAY)).all()
            acknowledged = {recording_id for recording_id in ids if db.get(RecordingRow, recording_id)}
        for recording_id in ids:
            if recording_id not in acknowledged:
                self.delete(recording_id)
        if ids:
            with self._database.writing() as db:
                db.execute(delete(RecordingFileRow).where(RecordingFileRow.created < now - DAY))

    def take_from_rows(self) -> None:
        """Move recordings that an earlier version stored in rows into files."""
        with self._database.reading() as db:
            ids = db.scalars(select(RecordingContentRow.id)).all()
        for recording_id in ids:
            with self._database.reading() as db:
                stored = db.get(RecordingContentRow, recording_id)
            if stored is not None:
                self._files.write(f"{recording_id}.zip", stored.content)
            with self._database.writing() as db:
                db.execute(delete(RecordingContentRow).where(RecordingContentRow.id == recording_id))


class FleetStores:
    """The folder or URL under which each fleet has its store."""

    def __init__(self, root: str) -> None:
        self._root = root.rstrip("/")

    def recordings_of(self, fleet: str) -> Files:
        """Return the files of a fleet's recordings, whose root is a store of `omnimate fleet run`."""
        return open_files(f"{self._root}/{fleet}")

    def results_of(self, fleet: str) -> Files:
        """Return the files of a fleet's results."""
        return open_files(f"{self._root}/{fleet}/results")


def read_in_process(
    root: Path,
    folder: Path,
    source: str,
    extract: Callable[[Recording], T],
    memory: int = MEMORY_LIMIT,
    timeout: float = READ_TIMEOUT,
) -> tuple[T, list[str]]:
    """Return what is needed of the recording in a folder, and what of its log could not be read, in words.

    Messages call the recording `source`, and its files relative to `root`. `extract` is a function of a
    module; the other process calls it within a memory [bytes] and a timeout [s], and only its result takes
    memory here.

    Raises:
        InvalidValueError: the recording cannot be read, or `extract` refuses it.
        TooLargeError: it takes too much memory or time.
    """
    end = time.monotonic() + timeout
    arguments = extract, str(root), str(folder.relative_to(root)), source
    # as nice as the service: a client waits for it
    with running("recording", _read, *arguments, memory=memory, niceness=0) as process:
        outcome = process.outcome(lambda _message: time.monotonic() < end)
    outcome = _require_read(outcome, timeout)
    return cast("T", outcome["extracted"]), outcome["problems"]


def find_unreadable(
    root: Path, folders: Sequence[str], memory: int = MEMORY_LIMIT, timeout: float = READ_TIMEOUT
) -> dict[str, str]:
    """Return which recordings in folders of `root` cannot be read, and why, in words.

    One other process reads them all, one after the other, each within the timeout [s].

    Raises:
        InvalidValueError: reading a recording ends in an error of ours.
        TooLargeError: a recording takes too much memory or time.
    """
    reading, end = "", 0.0

    def go_on(message: dict[str, Any]) -> bool:
        nonlocal reading, end
        if message:
            reading, end = message["doing"], time.monotonic() + timeout
        return not reading or time.monotonic() < end

    with running("recording", _read_all, str(root), folders, memory=memory, niceness=0) as process:
        outcome = process.outcome(go_on)
    return cast("dict[str, str]", _require_read(outcome, timeout, reading)["unreadable"])


def _require_read(outcome: dict[str, Any] | None, timeout: float, folder: str = "") -> dict[str, Any]:
    """Return the outcome of a process that reads, or raise its error, which names a folder of several."""
    if outcome is None:
        why = f"this recording was not read within {timeout:g} s"
    elif "died" in outcome:
        why = f"this recording cannot be read: {outcome['died']}"
    elif "limit" in outcome:
        why = outcome["error"]
    elif "error" in outcome:
        raise InvalidValueError(folder or "recording", outcome["error"])
    else:
        return outcome
    about = f"{folder}: " if folder else ""
    raise TooLargeError(f"{about}{why}; cut it into shorter ones")


def read_relative(root: str, folder: str, source: str) -> tuple[Recording, list[str]]:
    """Return the recording in a folder of `root`, where this process then works, and its log's problems.

    Both these and errors name its files relative to `root`, so that they do not reveal paths of this machine.
    """
    os.chdir(root)
    loaded = read_recording(Path(folder))
    problems = [problem[:MAX_PROBLEM_LENGTH] for problem in loaded.log.blocks.problems()]
    if len(problems) > MAX_PROBLEMS:  # lines come first, then what is wrong with the whole log
        half = MAX_PROBLEMS // 2
        problems = problems[:half] + problems[-half:]
    return replace(loaded.recording, source=source), problems


def _read(
    _report: Callable[[float, str], None], extract: Callable[[Recording], object], *recording: str
) -> dict[str, Any]:
    loaded, problems = read_relative(*recording)
    return {"extracted": extract(loaded), "problems": problems}


def _read_all(
    report_progress: Callable[[float, str], None], root: str, folders: Sequence[str]
) -> dict[str, Any]:
    unreadable = {}
    for number, folder in enumerate(folders):
        report_progress(number / len(folders), folder)
        try:
            read_relative(root, folder, folder)
        except OmnimateError as error:
            unreadable[folder] = str(error)
    return {"unreadable": unreadable}
