"""The recording folder: `vehicle.toml`, `can.log` (or `can.log.gz`), `poses.csv`, `run.toml` on one clock.

Files are written atomically, `can.log` last: a folder without it is no recording yet.
"""

from __future__ import annotations

import gzip
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from omnimate.files.logs.assemble import Assembly, assemble
from omnimate.files.logs.blocks import LogReadResult, read_log
from omnimate.files.logs.formats.candump_text import candump_text
from omnimate.files.logs.recording_to_frames import frames_of_recording
from omnimate.files.recordings.events_jsonl import EVENTS
from omnimate.files.recordings.poses_csv import read_poses, write_poses
from omnimate.files.recordings.run_toml import read_run, write_run
from omnimate.vehicle.atomic import write_bytes
from omnimate.vehicle.errors import RecordingError
from omnimate.vehicle.file import load_vehicle, save_vehicle

if TYPE_CHECKING:
    from omnimate.vehicle.recording import Recording

VEHICLE, LOG, POSES, RUN = "vehicle.toml", "can.log", "poses.csv", "run.toml"

LATEST_TIME = 2.0**32  # [s], in the year 2106: stamps of candump logs have ten digits before the point
_CLOCK_TOLERANCE = 1.0  # [s] that a lap may start before or end after the log (assumption)


@dataclass(frozen=True, slots=True)
class LoadedRecording:
    """A recording with the statistics of its assembly and its log.

    The recording has its poses and run; the log has the lines that could not be read.
    """

    recording: Recording
    assembly: Assembly
    log: LogReadResult


def load_recording(folder: Path | str) -> Recording:
    """Return the recording in a folder; `read_recording` also returns its statistics.

    Raises:
        VehicleFileError: `vehicle.toml` is absent or describes no possible robot.
        LogError: `can.log` cannot be read.
        RecordingError: A file is missing, or the files contradict each other or the format.
    """
    return read_recording(folder).recording


def read_recording(folder: Path | str) -> LoadedRecording:
    """Return the recording in a folder with its statistics; errors as `load_recording`."""
    folder = Path(folder)
    if not folder.is_dir():
        raise RecordingError(folder, "no such folder; a recording is a folder with vehicle.toml and can.log")
    vehicle = load_vehicle(folder / VEHICLE)
    log = read_log(log_path(folder))
    assembly = assemble(log.frames, vehicle, str(folder))
    poses = read_poses(folder / POSES, vehicle.trucks) if (folder / POSES).exists() else None
    run = read_run(folder / RUN) if (folder / RUN).exists() else None
    recording = replace(assembly.recording, poses=poses, run=run)
    _check_clock(recording, folder)
    return LoadedRecording(recording, assembly, log)


def log_path(folder: Path) -> Path:
    """Return the log in a recording folder.

    Raises:
        RecordingError: The folder holds no log.
    """
    for name in (LOG, f"{LOG}.gz"):
        if (folder / name).exists():
            return folder / name
    raise RecordingError(folder, f"neither {LOG} nor {LOG}.gz in it")


def check_free(folder: Path) -> None:
    """Raise a `RecordingError` for a folder that holds a recording already."""
    for name in (LOG, f"{LOG}.gz"):
        if (folder / name).exists():
            raise RecordingError(folder, f"it holds a recording ({name}); choose another folder")


def remove_recording(folder: Path) -> None:
    """Remove a recording from a folder, so that another can be written there; other files stay.

    Raises:
        OSError: A file cannot be removed.
    """
    for name in (LOG, f"{LOG}.gz", POSES, RUN, EVENTS):
        (folder / name).unlink(missing_ok=True)


def save_recording(recording: Recording, folder: Path | str, *, compress: bool = False) -> None:
    """Write a recording as a folder, replacing one that is there.

    With `compress`, `can.log.gz` is written instead of `can.log`.

    Raises:
        RecordingError: The folder cannot be written, or a time cannot be read back.
    """
    folder = Path(folder)
    _check_readable(recording)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        remove_recording(folder)
        save_vehicle(recording.vehicle, folder / VEHICLE)
        if recording.poses is not None:
            write_poses(recording.poses, folder / POSES)
        if recording.run is not None:
            write_run(recording.run, folder / RUN)
        text = b"".join(candump_text(frames_of_recording(recording)))
        log = folder / (f"{LOG}.gz" if compress else LOG)
        write_bytes(log, gzip.compress(text, 6) if compress else text)
    except OSError as error:
        raise RecordingError(folder, f"cannot be written: {error.strerror or error}") from error


def _check_readable(recording: Recording) -> None:
    """Raise an error for times that could not be read back."""
    wrong = recording.time[~((recording.time >= 0.0) & (recording.time <= LATEST_TIME))]
    if len(wrong):
        raise RecordingError(
            recording.source, f"time {wrong[0]:g} s; expected seconds since 1970, 0 to {LATEST_TIME:.0f}"
        )


def _check_clock(recording: Recording, folder: Path) -> None:
    """Raise an error for laps that the log does not cover, or no pose in it: they must be on its clock."""
    first, last = float(recording.time.min()), float(recording.time.max())  # the clock may go back
    times = np.zeros(0) if recording.poses is None else recording.poses.time
    if len(times) and (times[0] > last + _CLOCK_TOLERANCE or times[-1] < first - _CLOCK_TOLERANCE):
        raise RecordingError(
            folder / POSES,
            f"the poses from {times[0]:.3f} s to {times[-1]:.3f} s are not within the log,"
            f" {first:.3f} s to {last:.3f} s; all files must share its clock",
        )
    for number, lap in enumerate(recording.run.laps if recording.run else (), start=1):
        if lap.start < first - _CLOCK_TOLERANCE or lap.end > last + _CLOCK_TOLERANCE:
            raise RecordingError(
                folder / RUN,
                f"lap {number} from {lap.start:.3f} s to {lap.end:.3f} s is not within the log,"
                f" {first:.3f} s to {last:.3f} s; all files must share its clock, and where the log ends"
                " early, laps that it does not hold must be left out",
            )
