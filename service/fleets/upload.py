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
from omnimate.service.fleets.models import MAX_NAME_LENGTH, PLAIN_PATTERN, Upload
from omnimate.service.recording_zip import opened_zip
from omnimate.service.store.recordings import find_unreadable

if TYPE_CHECKING:
    from omnimate.fleet.batch.files import Files

MAX_SHOWN = 100  # recordings that cannot be read, in a message
MAX_FILES = 20_000  # in a zip: five of each recording, of 1000 robots and four laps
_PLAIN = rf"(?=[^/]{{1,{MAX_NAME_LENGTH}}}/){PLAIN_PATTERN.strip('^$')}"
_FILES = "|".join(re.escape(name) for name in (VEHICLE, LOG, f"{LOG}.gz", POSES, RUN))
_MEMBER = re.compile(rf"robot=({_PLAIN})/day=([0-9-]{{10}})/({_PLAIN})/({_FILES})")


def store_day(files: Files, content: bytes, limit: int, now: float) -> Upload:
    """Write the recordings of a zip into a store; those that are there already are replaced.

    Nothing is stored before all recordings of the zip were unpacked and read. A vehicle.toml is written last:
    a recording without it is none, so a half stored upload shows nothing that is not whole, and may be sent
    again. All files are unpacked up to `limit` [bytes], and of no later day than `now` [s since 1970] and the
    day after it.

    Raises:
        MediaTypeError: the content is not a zip.
        InvalidValueError: the zip holds something else, or a recording that cannot be read, or that is of a
            day that has not come yet.
        TooLargeError: the zip holds too many files, or they are larger than the limit, or a recording takes
            too much memory or time.
    """
    expected = "folders robot=NAME/day=YYYY-MM-DD/RECORDING/"
    with opened_zip(content, MAX_FILES, limit, expected) as archive, TemporaryDirectory() as place:
        # The day after the present one of UTC may have begun in other time zones.
        last = datetime.fromtimestamp(now, UTC).date() + timedelta(days=1)
        upload = _checked(archive.names, last.isoformat())
        for name in archive.names:
            archive.extract(name, Path(place) / name)
        folders = sorted({name.rpartition("/")[0] for name in archive.names})
        _require_readable(Path(place), folders)
        for folder in folders:
            for name in files.glob(f"{folder}/*"):
                if name not in archive.names:
                    files.delete(name)
        for name in sorted(archive.names, key=lambda name: (name.endswith(VEHICLE), name)):
            files.write(name, (Path(place) / name).read_bytes())
    return upload


def _require_readable(place: Path, folders: list[str]) -> None:
    """Refuse recordings that a batch could not read; all are named, so that they can be left out."""
    unreadable = find_unreadable(place, folders)
    if unreadable:
        shown = "; ".join(unreadable[:MAX_SHOWN]) + (" ..." if len(unreadable) > MAX_SHOWN else "")
        raise InvalidValueError(
            "zip",
            f"{len(unreadable)} of {len(folders)} recordings cannot be read, and none was stored; mend them, "
            f"or leave them out: {shown}",
        )


def _checked(names: list[str], last: str) -> Upload:
    """Return the content of a zip, whose recordings are of days up to `last`."""
    recordings: dict[tuple[str, str, str], set[str]] = {}
    for name in names:
        match = _MEMBER.fullmatch(name)
        if match is None or not is_date(match[2]):
            raise InvalidValueError(
                "zip",
                f"{name[:200]!r}; expected robot=NAME/day=YYYY-MM-DD/RECORDING/ with vehicle.toml, can.log "
                "or can.log.gz, poses.csv, run.toml; names of "
                f"{MAX_NAME_LENGTH} letters, digits, '.', '_', '-' at most",
            )
        robot, day, recording, file = match.groups()
        if day > last:
            raise InvalidValueError(
                "zip",
                f"robot={robot}/day={day}/{recording}: this day has not come yet; expected one up to {last}, "
                "by the clock of the service: correct the date of the recording, or that clock",
            )
        recordings.setdefault((robot, day, recording), set()).add(file)
    if not recordings:
        raise InvalidValueError("zip", "no recording in it; expected robot=NAME/day=YYYY-MM-DD/RECORDING/")
    for (robot, day, recording), kinds in recordings.items():
        if VEHICLE not in kinds or not kinds & {LOG, f"{LOG}.gz"}:
            raise InvalidValueError(
                "zip", f"robot={robot}/day={day}/{recording}: expected vehicle.toml and can.log or can.log.gz"
            )
    return Upload(
        recordings=len(recordings),
        robots=sorted({robot for robot, _, _ in recordings}),
        days=sorted({day for _, day, _ in recordings}),
    )
