"""A store of recordings, `robot=NAME/day=DATE/RECORDING/`, and the key that identifies a result."""

from __future__ import annotations

import hashlib
import tempfile
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import date
from glob import escape
from pathlib import Path
from typing import TYPE_CHECKING

from omnimate import __version__
from omnimate.files.recordings.folder import LOG, POSES, RUN, VEHICLE
from omnimate.fleet.batch.files import LocalFiles
from omnimate.fleet.errors import FleetError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from omnimate.fleet.batch.files import Files

RESULTS_FORMAT = 2  # version of the results' format; another one makes all results outdated
KEY_LENGTH = 16  # characters of the key of a result
_FILES = (VEHICLE, LOG, f"{LOG}.gz", POSES, RUN)


@dataclass(frozen=True, slots=True, order=True)
class StoredRecording:
    """A recording in a store.

    The day is YYYY-MM-DD; the name is unique among those of the robot on this day.
    """

    robot: str
    day: str
    name: str

    @property
    def partition(self) -> str:
        """Path of its partition, in the store and in each table of the results."""
        return f"robot={self.robot}/day={self.day}"

    @property
    def path(self) -> str:
        """Path of its folder in the store."""
        return f"{self.partition}/{self.name}"


def make_key(version: Mapping[str, str], *, diagnosed: bool) -> str:
    """Return the key of a result, by the version from `folder_of`, and whether mismatches are diagnosed."""
    parts = version["recording_hash"], version["vehicle_hash"], version["tool"], str(diagnosed)
    return _hash("\n".join(parts).encode())[:KEY_LENGTH]


def is_date(day: str) -> bool:
    """Return whether a text is a date, YYYY-MM-DD."""
    try:
        return date.fromisoformat(day).isoformat() == day
    except ValueError:
        return False


def recordings_in(files: Files, day: str) -> tuple[list[StoredRecording], tuple[str, ...]]:
    """Return the recordings of a store in the order of their paths, and the folders whose day is no date.

    The day is YYYY-MM-DD, or "*" for all.

    Raises:
        FleetError: There is no recording.
    """
    found, undated = [], []
    for path in files.glob(f"robot=*/day={day}/*/{VEHICLE}"):
        robot, of_day, name, _ = path.split("/")
        stored = StoredRecording(robot.removeprefix("robot="), of_day.removeprefix("day="), name)
        if is_date(stored.day):
            found.append(stored)
        else:
            undated.append(stored.partition)
    if not found:
        raise FleetError(
            files.url,
            f"no recording{'' if day == '*' else f' of {day}'}"
            f"{f' ({undated[0]} is of no date)' if undated else ''}; expected recording folders under "
            "robot=NAME/day=YYYY-MM-DD/, such as robot=tug-1/day=2026-03-02/lap-1/ with can.log and "
            "vehicle.toml: move yours there, or write an example with `omnimate fleet simulate FOLDER`",
        )
    return found, tuple(dict.fromkeys(undated))


@contextmanager
def folder_of(files: Files, stored: StoredRecording) -> Iterator[tuple[Path, dict[str, str]]]:
    """Yield a recording as a local folder, and the version of its results: hashes, and the software.

    The keys of the version are columns of the table `recordings`.
    """
    contents = {
        path.rpartition("/")[2]: files.read(path)
        for path in files.glob(f"{escape(stored.path)}/*")
        if path.rpartition("/")[2] in _FILES
    }
    recording = (name.encode() + content for name, content in contents.items() if name != VEHICLE)
    version = {
        "recording_hash": _hash(*recording),  # of log, poses and run
        "vehicle_hash": _hash(contents.get(VEHICLE, b"")),
        "tool": f"{__version__}+{RESULTS_FORMAT}",
    }
    if isinstance(files, LocalFiles):
        yield files.root / stored.path, version
        return
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / stored.name
        folder.mkdir()
        for name, content in contents.items():
            (folder / name).write_bytes(content)
        yield folder, version


def _hash(*parts: bytes) -> str:
    digest = hashlib.sha256()
    for part in parts:
        digest.update(hashlib.sha256(part).digest())
    return digest.hexdigest()
