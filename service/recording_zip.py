"""Recording folders as zip files, which are checked while they are unpacked."""

from __future__ import annotations

import io
import stat
import zipfile
from pathlib import PurePosixPath
from typing import TYPE_CHECKING

from omnimate.service.errors import InvalidValueError, MediaTypeError, TooLargeError

if TYPE_CHECKING:
    from pathlib import Path

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
