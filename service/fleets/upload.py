"""A day's recordings in one zip: `robot=NAME/day=YYYY-MM-DD/RECORDING/` and its files."""

from __future__ import annotations

import re
from datetime import UTC, datetime, timedelta
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from omnimate.files.recordings.folder import LOG, POSES, RUN, VEHICLE
from omnimate.fleet.batch.store import is_date
from omnimate.service.errors import InvalidValueError
from omnimate.service.fleets.models import MAX_NAME_LENGTH, PLAIN_PATTERN, Failure, Upload
from omnimate.service.recording_zip import opened_zip
from omnimate.service.store.recordings import find_unreadable

if TYPE_CHECKING:
    from omnimate.fleet.batch.files import Files

MAX_SHOWN = 100  # recordings that cannot be read, in a message
MAX_FILES = 20_000  # in a zip: five of each recording, of 1000 robots and four laps
_PLAIN = rf"(?=[^/]{{1,{MAX_NAME_LENGTH}}}/){PLAIN_PATTERN.strip('^$')}"
_FILES = "|".join(re.escape(name) for name in (VEHICLE, LOG, f"{LOG}.gz", POSES, RUN))
_MEMBER = re.compile(rf"(robot={_PLAIN}/day=([0-9-]{{10}})/{_PLAIN})/(?:{_FILES})")


def store_day(files: Files, content: bytes, limit: int, now: float) -> Upload:
    """Write the recordings of a zip into a store; those that are there already are replaced.

    Nothing is stored before all recordings of the zip were unpacked and read. Those that cannot be read are
    named in the answer and not stored: one broken log does not keep the day of a fleet from its report. A
    vehicle.toml is written last: a recording without it is none, so a half stored upload shows nothing that
    is not whole, and may be sent again. All files are unpacked up to `limit` [bytes], and of no later day
    than `now` [s since 1970] and the day after it.

    Raises:
        MediaTypeError: the content is not a zip.
        InvalidValueError: the zip holds something else, or a recording of a day that has not come yet, or
            none of its recordings can be read.
        TooLargeError: the zip holds too many files, or they are larger than the limit, or a recording takes
            too much memory or time.
    """
    expected = "folders robot=NAME/day=YYYY-MM-DD/RECORDING/"
    with opened_zip(content, MAX_FILES, limit, expected) as archive, TemporaryDirectory() as place:
        # The day after the present one of UTC may have begun in other time zones.
        last = datetime.fromtimestamp(now, UTC).date() + timedelta(days=1)
        recordings = _checked(archive.names, last.isoformat())
        for name in archive.names:
            archive.extract(name, Path(place) / name)
        unreadable = find_unreadable(Path(place), sorted(recordings))
        stored = {folder: names for folder, names in recordings.items() if folder not in unreadable}
        if not stored:
            raise InvalidValueError("zip", _none_readable(unreadable))
        for folder, names in stored.items():
            for name in files.glob(f"{folder}/*"):
                if name not in names:
                    files.delete(name)
        sent = [name for names in stored.values() for name in names]
        for name in sorted(sent, key=lambda name: (name.endswith(VEHICLE), name)):
            files.write(name, (Path(place) / name).read_bytes())
    parts = [_parts(folder) for folder in stored]
    return Upload(
        recordings=len(stored),
        robots=sorted({part["robot"] for part in parts}),
        days=sorted({part["day"] for part in parts}),
        refused=[Failure(**_parts(folder), problem=problem) for folder, problem in unreadable.items()],
    )


def _none_readable(unreadable: dict[str, str]) -> str:
    problems = list(unreadable.values())
    shown = "; ".join(problems[:MAX_SHOWN]) + (" ..." if len(problems) > MAX_SHOWN else "")
    return f"none of {len(problems)} recordings can be read, and none was stored; mend them: {shown}"


def _parts(folder: str) -> dict[str, str]:
    """Return robot, day and recording of a folder `robot=NAME/day=YYYY-MM-DD/RECORDING`, by these names."""
    robot, day, recording = folder.split("/")
    return {"robot": robot.removeprefix("robot="), "day": day.removeprefix("day="), "recording": recording}


def _checked(names: list[str], last: str) -> dict[str, set[str]]:
    """Return the files of each recording of a zip, by its folder; they are of days up to `last`."""
    recordings: dict[str, set[str]] = {}
    for name in names:
        match = _MEMBER.fullmatch(name)
        if match is None or not is_date(match[2]):
            raise InvalidValueError(
                "zip",
                f"{name[:200]!r}; expected robot=NAME/day=YYYY-MM-DD/RECORDING/ with vehicle.toml, can.log "
                "or can.log.gz, poses.csv, run.toml; names of "
                f"{MAX_NAME_LENGTH} letters, digits, '.', '_', '-' at most",
            )
        folder, day = match[1], match[2]
        if day > last:
            raise InvalidValueError(
                "zip",
                f"{folder}: this day has not come yet; expected one up to {last}, "
                "by the clock of the service: correct the date of the recording, or that clock",
            )
        recordings.setdefault(folder, set()).add(name)
    if not recordings:
        raise InvalidValueError("zip", "no recording in it; expected robot=NAME/day=YYYY-MM-DD/RECORDING/")
    for folder, files in recordings.items():
        logs = {f"{folder}/{LOG}", f"{folder}/{LOG}.gz"}
        if f"{folder}/{VEHICLE}" not in files or not files & logs:
            raise InvalidValueError("zip", f"{folder}: expected vehicle.toml and can.log or can.log.gz")
    return recordings
