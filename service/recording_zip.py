"""Recordings as zip files: checked before they are unpacked, and read before they are kept."""

from __future__ import annotations

import io
import secrets
import stat
import tempfile
import time
import zipfile
from dataclasses import replace
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

from omnimate.files.recordings.folder import load_recording
from omnimate.service.errors import InvalidValueError, MediaTypeError, TooLargeError
from omnimate.service.store.tables import RecordingRow

if TYPE_CHECKING:
    from collections.abc import Iterator

    from omnimate.vehicle.recording import Recording

MOST_FILES = 64  # in a zip
BLOCK = 1 << 20  # [bytes] that are unpacked at a time


def unpack(content: bytes, folder: Path, limit: int) -> Path:
    """Unpack a zip into a folder; return the folder that holds the recording's files.

    Args:
        content: The content of the zip.
        folder: An empty folder.
        limit: The largest size of all unpacked files [bytes].

    Raises:
        MediaTypeError: the content is not a zip.
        InvalidValueError: a name in the zip leads out of the folder, or the zip holds no recording.
        TooLargeError: the zip holds too many files, or they are larger than the limit.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            members = [member for member in archive.infolist() if not member.is_dir()]
            if len(members) > MOST_FILES:
                raise TooLargeError(f"{len(members)} files; a recording folder has {MOST_FILES} at most")
            left = limit
            for member in members:
                left = _write(archive, member, folder / _name(member), left)
    except (zipfile.BadZipFile, NotImplementedError, RuntimeError, EOFError, OSError) as error:
        raise MediaTypeError(f"the zip cannot be read: {error}; zip a recording folder") from error
    return _within(folder)


def _name(member: zipfile.ZipInfo) -> PurePosixPath:
    """Return the name of a member, which must not lead out of the folder."""
    path = PurePosixPath(member.filename.replace("\\", "/"))
    plain = not path.is_absolute() and ".." not in path.parts and ":" not in member.filename
    plain = plain and "\0" not in member.filename and not stat.S_ISLNK(member.external_attr >> 16)
    if not plain or len(path.parts) > 2:
        raise InvalidValueError(
            "zip",
            f"{member.filename!r} leads out of the recording folder; expected a plain name such as can.log",
        )
    return path


def _write(archive: zipfile.ZipFile, member: zipfile.ZipInfo, path: Path, left: int) -> int:
    path.parent.mkdir(parents=True, exist_ok=True)
    with archive.open(member) as source, path.open("wb") as target:
        while block := source.read(BLOCK):
            left -= len(block)
            if left < 0:
                raise TooLargeError("the files in this zip are larger than the service accepts")
            target.write(block)
    return left


def _within(folder: Path) -> Path:
    if (folder / "vehicle.toml").is_file():
        return folder
    inner = [path for path in folder.iterdir() if (path / "vehicle.toml").is_file()]
    if len(inner) != 1:
        raise InvalidValueError(
            "zip",
            "no recording in it; expected vehicle.toml, can.log and the other files of a recording folder",
        )
    return inner[0]


def pack(folder: Path) -> bytes:
    """Return a recording folder as a zip."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=3) as archive:
        for path in sorted(folder.iterdir()):
            archive.write(path, path.name)
    return buffer.getvalue()


def make_row(name: str, content: bytes, recording: Recording) -> RecordingRow:
    """Return the database row of a recording."""
    return RecordingRow(
        id=secrets.token_hex(8),
        name=name,
        vehicle=recording.vehicle.name[:100],
        samples=len(recording),
        seconds=float(recording.time[-1] - recording.time[0]),
        laps=0 if recording.run is None else len(recording.run.laps),
        poses=0 if recording.poses is None else len(recording.poses.time),
        size=len(content),
        created=time.time(),
        content=content,
    )


def check_upload(name: str, content: bytes, limit: int) -> RecordingRow:
    """Return the database row of an uploaded zip, after its recording was read completely.

    Raises:
        MediaTypeError: the content is not a zip.
        InvalidValueError: the zip is not one of a recording folder.
        TooLargeError: the zip is larger than the limit [bytes] when it is unpacked.
        OmnimateError: the recording cannot be read.
    """
    with tempfile.TemporaryDirectory() as place:
        return make_row(name, content, load_recording(unpack(content, Path(place), limit)))


def load_rows(rows: list[RecordingRow], place: Path, limit: int) -> Iterator[Recording]:
    """Yield recordings of the database, each unpacked into a folder of its own in `place`."""
    for row in rows:
        folder = place / row.id
        folder.mkdir()
        yield replace(load_recording(unpack(row.content, folder, limit)), source=row.name)
