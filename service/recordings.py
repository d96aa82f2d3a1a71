"""Recordings as zips: checked before anything is unpacked, read before anything is kept."""

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

from service.errors import MediaProblem, TooLargeError, ValueProblem
from service.store.tables import RecordingRow
from vehicle.folder import load_recording

if TYPE_CHECKING:
    from collections.abc import Iterator

    from vehicle.recording import Recording

FILES = 64  # in a zip
READ = 1 << 20  # bytes at a time


def unpack(content: bytes, folder: Path, most: int) -> Path:
    """Unpack a zip into a folder; return the one in which the recording's files are.

    Args:
        content: of the zip.
        folder: empty.
        most: bytes that may come out of it.

    Raises:
        MediaProblem: it is no zip.
        ValueProblem: it holds a name that leads elsewhere, or no recording.
        TooLargeError: more comes out than allowed, whatever the zip says of itself.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            members = [one for one in archive.infolist() if not one.is_dir()]
            if len(members) > FILES:
                raise TooLargeError(f"{len(members)} files; a recording folder has {FILES} at most")
            left = most
            for member in members:
                left = _write(archive, member, folder / _name(member), left)
    except (zipfile.BadZipFile, NotImplementedError, RuntimeError, EOFError, OSError) as error:
        raise MediaProblem(f"no zip that can be read: {error}; zip a recording folder") from error
    return _within(folder)


def _name(member: zipfile.ZipInfo) -> PurePosixPath:
    """Return a member's name, which must be a plain one."""
    path = PurePosixPath(member.filename.replace("\\", "/"))
    plain = not path.is_absolute() and ".." not in path.parts and ":" not in member.filename
    plain = plain and "\0" not in member.filename and not stat.S_ISLNK(member.external_attr >> 16)
    if not plain or len(path.parts) > 2:
        raise ValueProblem(
            "zip",
            f"{member.filename!r} leads out of the recording folder; expected plain names such as can.log",
        )
    return path


def _write(archive: zipfile.ZipFile, member: zipfile.ZipInfo, path: Path, left: int) -> int:
    path.parent.mkdir(parents=True, exist_ok=True)
    with archive.open(member) as source, path.open("wb") as target:
        while block := source.read(READ):
            left -= len(block)
            if left < 0:
                raise TooLargeError("more comes out of this zip than the service takes; a zip bomb?")
            target.write(block)
    return left


def _within(folder: Path) -> Path:
    if (folder / "vehicle.toml").is_file():
        return folder
    inner = [one for one in folder.iterdir() if (one / "vehicle.toml").is_file()]
    if len(inner) != 1:
        raise ValueProblem(
            "zip",
            "no recording in it; expected vehicle.toml, can.log, and what else a recording folder has",
        )
    return inner[0]


def pack(folder: Path) -> bytes:
    """Return a recording folder as a zip."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=3) as archive:
        for path in sorted(folder.iterdir()):
            archive.write(path, path.name)
    return buffer.getvalue()


def row_of(name: str, content: bytes, recording: Recording) -> RecordingRow:
    """Return what is kept of a recording."""
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


def checked(name: str, content: bytes, most: int) -> RecordingRow:
    """Return what is kept of an uploaded zip, after it has been read as everybody will read it.

    Raises:
        MediaProblem, ValueProblem, TooLargeError: it is no zip of a recording folder.
        OmnimateError: what it holds is no recording.
    """
    with tempfile.TemporaryDirectory() as place:
        return row_of(name, content, load_recording(unpack(content, Path(place), most)))


def loaded(rows: list[RecordingRow], place: Path, most: int) -> Iterator[Recording]:
    """Yield kept recordings, unpacked into a folder."""
    for row in rows:
        folder = place / row.id
        folder.mkdir()
        yield replace(load_recording(unpack(row.content, folder, most)), source=row.name)
