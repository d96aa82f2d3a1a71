"""Uploaded zips of recordings, which are unpacked within limits on every layer of compression."""

from __future__ import annotations

import io
import stat
import zipfile
import zlib
from contextlib import contextmanager
from pathlib import PurePosixPath
from typing import TYPE_CHECKING

from omnimate.files.logs.formats.block_reader import BlockReader
from omnimate.files.recordings.folder import LOG, VEHICLE
from omnimate.service.errors import InvalidValueError, MediaTypeError, TooLargeError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

MAX_FILES = 64  # in the zip of one recording
MAX_LOG_LINES = 5_000_000  # of a log; reading one takes 210 bytes of memory
MAX_NAME_SIZE = 200  # [bytes] of a file or folder in it; file systems take 255
MAX_FILE_SIZE = 300_000_000  # [bytes]; a log of as many lines, each of 60 bytes, is not larger
BLOCK = 1 << 16  # [bytes] that are unpacked at a time; as many as shutil copies at a time (COPY_BUFSIZE)
_LOGS = (LOG, f"{LOG}.gz")
_ENTRY = b"PK\1\2"  # begins each entry of a zip's directory
_ENCRYPTED = 1  # among a file's flags
_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # zipfile unpacks all others without a limit

# What zipfile raises about a damaged zip: on its directory, names that are empty or no text, offsets, data.
_DAMAGE = (
    zipfile.BadZipFile, NotImplementedError, RuntimeError, EOFError, ValueError, IndexError, zlib.error,
)  # fmt: skip


class UploadedZip:
    """An uploaded zip, of which no more is unpacked than its limit."""

    def __init__(self, archive: zipfile.ZipFile, most_files: int, limit: int) -> None:
        self._archive, self._left = archive, limit
        self._members = {member.filename: member for member in archive.infolist() if not _is_left_out(member)}
        self.names = list(self._members)
        if len(self.names) > most_files:
            raise TooLargeError(f"{len(self.names)} files; send {most_files} at most in one zip")
        self._check_sizes()

    def _check_sizes(self) -> None:
        """Refuse a zip by what its directory says of it; `zipfile` unpacks no more than that."""
        for member in self._members.values():
            if member.flag_bits & _ENCRYPTED:
                raise MediaTypeError(
                    f"the zip cannot be read: {member.filename!r} is encrypted; zip it without a password"
                )
            if member.compress_type not in _METHODS:
                raise MediaTypeError(
                    f"the zip cannot be read: {member.filename!r} is packed by method "
                    f"{member.compress_type}; expected stored or deflated"
                )
            if member.file_size > MAX_FILE_SIZE:
                raise TooLargeError(
                    f"{member.filename!r} has {member.file_size} bytes; at most {MAX_FILE_SIZE}"
                )
        size = sum(member.file_size for member in self._members.values())
        if size > self._left:
            raise TooLargeError(f"{size} bytes when unpacked; at most {self._left} are accepted")

    def is_link(self, name: str) -> bool:
        """Return whether a file is a symbolic link."""
        return stat.S_ISLNK(self._members[name].external_attr >> 16)

    def extract(self, name: str, path: Path) -> None:
        """Write a file to a path; TooLargeError beyond what is left of the limit, or a log's lines."""
        path.parent.mkdir(parents=True, exist_ok=True)
        with self._archive.open(self._members[name]) as source, path.open("wb") as target:
            while block := source.read(BLOCK):
                self._take(len(block))
                target.write(block)
        if PurePosixPath(name).name in _LOGS:
            self._check_log(name, path)

    def _check_log(self, name: str, path: Path) -> None:
        """Count what a log unpacks to, before anything of it is parsed."""
        content, lines = BlockReader(path, BLOCK), 0
        while block := content.file.read(BLOCK):
            lines += block.count(b"\n")
            if lines > MAX_LOG_LINES or content.passed > min(MAX_FILE_SIZE, self._left + content.position):
                raise TooLargeError(
                    f"{name}: more than {MAX_LOG_LINES} lines, or {MAX_FILE_SIZE} bytes when unpacked; "
                    "cut the log into shorter ones"
                )
        self._take(max(0, content.passed - content.position))

    def _take(self, count: int) -> None:
        self._left -= count
        if self._left < 0:
            raise TooLargeError("the files in this zip are larger than the service accepts")


def _is_left_out(member: zipfile.ZipInfo) -> bool:
    """Return whether a file is none of a recording's: a folder, or what macOS adds for its Finder."""
    path = PurePosixPath(member.filename)
    return member.is_dir() or path.parts[:1] == ("__MACOSX",) or path.name == ".DS_Store"


@contextmanager
def opened_zip(content: bytes, most_files: int, limit: int, expected: str) -> Iterator[UploadedZip]:
    """Yield an uploaded zip; messages say what to zip (`expected`).

    Raises:
        MediaTypeError: the content is not a zip, here or within the block.
        TooLargeError: the zip holds too many files, or they are larger than the limit [bytes] when unpacked.
    """
    entries = content.count(_ENTRY)
    if entries > 2 * most_files:  # files and folders
        raise TooLargeError(f"{entries} files; send {most_files} at most in one zip")
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            yield UploadedZip(archive, most_files, limit)
    except UnicodeDecodeError as error:
        raise MediaTypeError("the zip cannot be read: a name in it is not UTF-8, as it should be") from error
    except _DAMAGE as error:
        raise MediaTypeError(f"the zip cannot be read: {error}; zip {expected}") from error


def unpack(content: bytes, folder: Path, limit: int) -> Path:
    """Unpack the zip of a recording into a folder; return the folder that holds the recording's files.

    Raises:
        MediaTypeError: the content is not a zip.
        InvalidValueError: a name in the zip leads out of the folder, or the zip does not hold one recording.
        TooLargeError: the zip holds too many files, or they are larger than the limit [bytes].
    """
    with opened_zip(content, MAX_FILES, limit, "a recording folder") as archive:
        paths = {name: _checked_path(archive, name) for name in archive.names}
        for path in paths.values():
            if path.parent in paths.values():
                raise InvalidValueError(
                    "zip", f"'{path.parent}' is a file and a folder; expected one of them"
                )
        inner = folder / _folder_of_recording(list(paths.values()))
        for name, path in paths.items():
            archive.extract(name, folder / path)
    return inner


def _checked_path(archive: UploadedZip, name: str) -> PurePosixPath:
    """Return the path of a file in the zip, which must not lead out of the folder."""
    path = PurePosixPath(name.replace("\\", "/"))
    plain = not path.is_absolute() and ".." not in path.parts and ":" not in name
    if not plain or "\0" in name or archive.is_link(name) or not path.parts:
        raise InvalidValueError(
            "zip", f"{name!r} leads out of the recording folder; expected a plain name such as can.log"
        )
    if len(path.parts) > 2:
        raise InvalidValueError(
            "zip", f"{name!r} is in a folder of a folder; zip the recording folder itself, or its files"
        )
    if any(len(part.encode()) > MAX_NAME_SIZE for part in path.parts):
        raise InvalidValueError("zip", f"{name[:60]!r}...: expected names of {MAX_NAME_SIZE} bytes at most")
    return path


def _folder_of_recording(paths: list[PurePosixPath]) -> PurePosixPath:
    """Return the folder of the one recording among the paths of a zip."""
    described = sorted({path.parent for path in paths if path.name == VEHICLE})
    if len(described) == 1 or PurePosixPath() in described:
        return described[0]
    if described:
        names = ", ".join(map(str, described))
        raise InvalidValueError(
            "zip", f"{len(described)} recordings in it ({names}); send each in a zip of its own"
        )
    logs = [str(path) for path in paths if path.name in _LOGS]
    if logs:
        raise InvalidValueError(
            "zip", f"no {VEHICLE} in it; put the robot's {VEHICLE} into the folder of {logs[0]}"
        )
    raise InvalidValueError(
        "zip", f"no recording in it; expected {VEHICLE}, {LOG} and the other files of a recording folder"
    )
