"""Recordings are files, those of sessions and those of fleets; the database says which there are."""

from __future__ import annotations

import secrets
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from sqlalchemy import select

from omnimate.files.recordings.folder import load_recording
from omnimate.fleet.batch.files import open_files
from omnimate.service.errors import NotFoundError
from omnimate.service.recording_zip import unpack
from omnimate.service.store.tables import RecordingContentRow, RecordingRow

if TYPE_CHECKING:
    from omnimate.fleet.batch.files import Files
    from omnimate.service.store.database import Database
    from omnimate.vehicle.recording import Recording

FOLDER = "_recordings"  # no fleet's: their names begin with a letter or a digit
DAY = 86400.0  # [s]


class RecordingStore:
    """The recordings that were uploaded, or driven for a session: one zip each.

    A file is written before its row is committed, and deleted after its row: a row always has its file.

    Args:
        root: The folder or URL of all stores.
        limit: The largest recording after it was unpacked [bytes].
    """

    def __init__(self, root: str, limit: int) -> None:
        self._files, self._limit = open_files(f"{root.rstrip('/')}/{FOLDER}"), limit

    def add(self, name: str, content: bytes, recording: Recording) -> RecordingRow:
        """Write a recording's zip; return the row, which the caller adds to the database."""
        row = RecordingRow(
            id=secrets.token_hex(8),
            name=name,
            vehicle=recording.vehicle.name[:100],
            samples=len(recording),
            seconds=float(recording.time[-1] - recording.time[0]),
            laps=0 if recording.run is None else len(recording.run.laps),
            poses=0 if recording.poses is None else len(recording.poses.time),
            size=len(content),
            created=time.time(),
        )
        self._files.write(_path(row.id, row.created), content)
        return row

    def add_upload(self, name: str, content: bytes) -> RecordingRow:
        """Write an uploaded zip after its recording was read completely; return its row.

        Raises:
            MediaTypeError: the content is not a zip.
            InvalidValueError: the zip is not one of a recording folder.
            TooLargeError: the zip is larger than the limit when it is unpacked.
            OmnimateError: the recording cannot be read.
        """
        with tempfile.TemporaryDirectory() as place:
            recording = load_recording(unpack(content, Path(place), self._limit))
        return self.add(name, content, recording)

    def content(self, row: RecordingRow) -> bytes:
        """Return the zip of a recording.

        Raises:
            NotFoundError: the recording was deleted meanwhile.
        """
        try:
            return self._files.read(_path(row.id, row.created))
        except FileNotFoundError as error:
            raise NotFoundError("recording", row.id) from error

    def load(self, row: RecordingRow) -> Recording:
        """Return a recording; NotFoundError where it was deleted meanwhile."""
        with tempfile.TemporaryDirectory() as place:
            return replace(load_recording(self.unpack(row, Path(place))), source=row.name)

    def unpack(self, row: RecordingRow, folder: Path) -> Path:
        """Unpack a recording into an empty folder; NotFoundError where it was deleted meanwhile."""
        return unpack(self.content(row), folder, self._limit)

    def delete(self, row: RecordingRow) -> None:
        """Delete the file of a recording whose row is deleted."""
        self._files.delete(_path(row.id, row.created))

    def delete_orphans(self, database: Database, now: float) -> None:
        """Delete files without a row that are older than a day: of uploads that were never acknowledged."""
        old = {path for path in self._files.glob("*.zip") if path < _path("", now - DAY)}
        if old:
            with database.reading() as db:
                old -= {_path(*key) for key in db.execute(select(RecordingRow.id, RecordingRow.created))}
            for path in old:
                self._files.delete(path)

    def take_from_rows(self, database: Database) -> None:
        """Move recordings that an earlier version stored in rows into files."""
        with database.reading() as db:
            ids = db.scalars(select(RecordingContentRow.id)).all()
        for recording_id in ids:
            with database.reading() as db:
                row = db.get(RecordingRow, recording_id)
                stored = db.get(RecordingContentRow, recording_id)
            if row is not None and stored is not None:
                self._files.write(_path(row.id, row.created), stored.content)
            with database.writing() as db:
                stored = db.get(RecordingContentRow, recording_id, with_for_update=True)
                if stored is not None:
                    db.delete(stored)


def _path(recording_id: str, created: float) -> str:
    """Return the name of a recording's file, which begins with its date."""
    return f"{time.strftime('%Y-%m-%d', time.gmtime(created))}-{recording_id}.zip"


class FleetStores:
    """The folder or URL under which each fleet has its store.

    Args:
        root: The folder or URL.
    """

    def __init__(self, root: str) -> None:
        self._root = root.rstrip("/")

    def store(self, fleet: str) -> str:
        """Return the folder or URL of a fleet's recordings, as `omnimate fleet run` takes it."""
        return f"{self._root}/{fleet}"

    def results(self, fleet: str) -> str:
        """Return the folder or URL of a fleet's results."""
        return f"{self.store(fleet)}/results"

    def recordings_of(self, fleet: str) -> Files:
        """Return the files of a fleet's recordings."""
        return open_files(self.store(fleet))

    def results_of(self, fleet: str) -> Files:
        """Return the files of a fleet's results."""
        return open_files(self.results(fleet))
