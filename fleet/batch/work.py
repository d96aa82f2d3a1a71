"""Processing of one recording: its results as tables, written once, under their key; and their removal."""

from __future__ import annotations

import json
from contextlib import suppress
from dataclasses import replace
from glob import escape
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from omnimate.calib.errors import CalibrationError
from omnimate.calib.umbmark.experiment import experiment_of_recordings
from omnimate.files.recordings.folder import VEHICLE, load_recording
from omnimate.fleet.batch.files import open_files
from omnimate.fleet.batch.store import KEY_LENGTH, folder_of, make_key
from omnimate.fleet.batch.tables import TABLES, decode_rows, encode_columns
from omnimate.fleet.features import (
    MIN_SEGMENTS,
    crossing_columns,
    estimate_joints,
    name_kind,
    segment_columns,
)
from omnimate.fleet.model.evidence import weigh_segments
from omnimate.fleet.report_store import delete_history_day, delete_report
from omnimate.fleet.segments import JOINT_NUMBERS, PARAMETERS, cut_segments
from omnimate.mismatch import diagnose
from omnimate.mismatch.triage import triage
from omnimate.vehicle.errors import OmnimateError
from omnimate.vehicle.floor import CONCRETE_ROUGHNESS
from omnimate.vehicle.odometry import truck_travel

if TYPE_CHECKING:
    from pathlib import Path

    from omnimate.fleet.batch.files import Files
    from omnimate.fleet.batch.store import StoredRecording
    from omnimate.fleet.model.evidence import Evidence
    from omnimate.mismatch.diagnosis import Where
    from omnimate.vehicle.recording import Recording

Status = Literal["done", "known"]
Columns = dict[str, Any]
Number = tuple[str, str, float, float | None]  # name, unit, value and sigma of a row of `numbers`
# Tables of a recording in the order of writing: if `recordings` exists, all others do.
RECORDING_TABLES = ("crossings", "ways", "numbers", "recordings")
# [s] part of a drive with a linkage that is diagnosed. The linkage observes both trucks in every sample, and
# a diagnosis takes time and memory in proportion to the samples: five minutes take 20 to 90 s of processor
# time and 2.7 GB, while a mismatch that triage finds, such as a joint of the floor, lasts some seconds. A
# single truck is observed at docks only, so that its whole drive is diagnosed, which takes a second or two.
DIAGNOSED_PART = 60.0


class Processed(NamedTuple):
    """The outcome of one recording.

    `status`: its results have been written now, or existed already; `error`: why it cannot be read.
    """

    status: Status
    error: str | None


def process_recording(store: str, results: str, stored: StoredRecording, *, diagnosed: bool) -> Processed:
    """Write the results of one recording unless they exist already.

    Store and results are folders or URLs; `diagnosed`: a mismatch by triage is diagnosed, too.

    Raises:
        FleetError: A library is missing.
        OSError: Files cannot be read or written.
    """
    target = open_files(results)
    with folder_of(open_files(store), stored) as (folder, version):
        key = make_key(version, diagnosed=diagnosed)
        path = _path("recordings", stored, key)
        if target.exists(path):
            with suppress(ValueError):  # of pyarrow: the file is damaged, and is written again
                return Processed("known", decode_rows(target.read(path))[0]["error"])
        tables = _make_tables(folder, diagnosed=diagnosed)
    tables["recordings"] |= {name: [value] for name, value in {"key": key, **version}.items()}
    for table in RECORDING_TABLES:
        count = len(next(iter(tables[table].values())))
        columns = {"recording": [stored.name] * count, **tables[table]}
        target.write(_path(table, stored, key), encode_columns(table, columns))
    _delete_old_results(target, stored, key)
    return Processed("done", tables["recordings"]["error"][0])


def _path(table: str, stored: StoredRecording, key: str) -> str:
    return f"{table}/{stored.path}-{key}.parquet"


def _delete_old_results(target: Files, stored: StoredRecording, key: str) -> None:
    """Delete results of the same recording with other keys: of other data, vehicle.toml or software."""
    new = {_path(table, stored, key) for table in RECORDING_TABLES}
    for path in _result_paths(target, stored):
        if path not in new:
            target.delete(path)


def _result_paths(results: Files, stored: StoredRecording) -> list[str]:
    """Return the paths of a recording's results, in the reverse order of writing: `recordings` first."""
    # `*` would also match the rest of a longer name and its key.
    pattern = f"{escape(stored.path)}-{'?' * KEY_LENGTH}.parquet"
    tables = reversed(RECORDING_TABLES)
    return [path for table in tables for path in results.glob(f"{table}/{pattern}")]


def _empty(table: str) -> Columns:
    return {name: [] for name in TABLES[table] if name != "recording"}


def _make_tables(folder: Path, *, diagnosed: bool) -> dict[str, Columns]:
    """Return the tables of a recording; if it cannot be processed, `recordings` has the reason in `error`."""
    tables = {table: _empty(table) for table in RECORDING_TABLES}
    row: Columns = dict.fromkeys(tables["recordings"])
    try:
        recording = load_recording(folder)
        row |= _describe_drive(recording)
        cut = cut_segments(recording)
        tables["numbers"] = _estimate_numbers(
            recording, weigh_segments(*cut, CONCRETE_ROUGHNESS) if cut else None
        )
        if cut:
            tables["ways"], tables["crossings"] = segment_columns(cut[0]), crossing_columns(cut[1])
        row |= _run_triage(recording, diagnosed=diagnosed)
    except OmnimateError as error:
        row["error"] = str(error).replace(str(folder), folder.name)
    tables["recordings"] = {name: [value] for name, value in row.items()}
    return tables


def _describe_drive(recording: Recording) -> Columns:
    left, right, _ = truck_travel(recording, "a")
    return {
        "kind": name_kind(recording.vehicle),
        "floor": recording.run.floor if recording.run else "",
        "start": float(recording.time[0]),
        "duration": float(recording.time[-1] - recording.time[0]),
        "way": float(np.abs(np.diff(0.5 * (left + right))).sum()),
    }


def _run_triage(recording: Recording, *, diagnosed: bool) -> Columns:
    """Return the columns of triage and, if it finds a mismatch and `diagnosed` is set, of the diagnosis."""
    answer = triage([recording])
    closest = answer.closest[0] if answer.closest else None
    diagnosis = None
    if diagnosed and answer.verdict == "mismatch":
        found = diagnose([diagnosed_part(recording, answer.where)]).as_json()
        diagnosis = json.dumps(found, sort_keys=True).replace(
            recording.source, recording.source.rpartition("/")[2]
        )
    return {
        "triage": answer.verdict,
        "probability": answer.probability,
        "effect": closest.effect if closest else None,
        "component": closest.component if closest else None,
        "says": answer.says,
        "diagnosis": diagnosis,
    }


def diagnosed_part(recording: Recording, where: Where) -> Recording:
    """Return the part to diagnose: `DIAGNOSED_PART` around the first mismatch, without one around the middle.

    A recording of a single truck, or a shorter one, is returned whole.
    """
    first, last = float(recording.time[0]), float(recording.time[-1])
    if recording.vehicle.linkage is None or last - first <= DIAGNOSED_PART:
        return recording
    interval = min(where.intervals, default=(first, last))
    start = min(max(0.5 * (interval[0] + interval[1]) - 0.5 * DIAGNOSED_PART, first), last - DIAGNOSED_PART)
    return _cut_recording(recording, start, start + DIAGNOSED_PART)


def _cut_recording(recording: Recording, start: float, end: float) -> Recording:
    """Return a recording from `start` to `end` [s]: samples and poses, and laps and gaps fully inside."""
    rows, poses, run = recording.between(start, end), recording.poses, recording.run
    if poses is not None:
        inside = (poses.time >= start) & (poses.time <= end)
        poses = poses.select(inside)
    if run is not None:
        run = replace(run, laps=tuple(lap for lap in run.laps if start <= lap.start and lap.end <= end))
    return replace(
        recording,
        time=recording.time[rows],
        counts=recording.counts[rows],
        present=recording.present[rows],
        commands=None if recording.commands is None else recording.commands[rows],
        poses=poses if poses is not None and len(poses.time) else None,
        run=run,
        gaps=tuple(gap for gap in recording.gaps if start <= gap.start and gap.end <= end),
    )


def _estimate_numbers(recording: Recording, evidence: Evidence | None) -> Columns:
    """Return the table `numbers`: parameters relative to vehicle.toml, joint biases, and UMBmark errors."""
    rows: list[Number] = []
    if evidence is not None and len(evidence.residual) >= 3 * MIN_SEGMENTS:
        information, score = evidence.robot_information()
        covariance = np.linalg.pinv(information)
        values, sigmas = (covariance @ score).tolist(), np.sqrt(np.diag(covariance)).tolist()
        rows += [(name, "1", *number) for name, *number in zip(PARAMETERS, values, sigmas, strict=True)]
    joints = estimate_joints(recording)
    biases, sigmas = joints.bias.tolist(), joints.sigma.tolist()
    rows += [(name, "rad", *number) for name, *number in zip(JOINT_NUMBERS, biases, sigmas, strict=False)]
    rows += _estimate_umbmark(recording)
    names = "name", "unit", "value", "sigma"
    return dict(zip(names, map(list, zip(*rows, strict=True)), strict=True)) if rows else _empty("numbers")


def _estimate_umbmark(recording: Recording) -> list[Number]:
    """Return E_max,syst (U) of each truck that drove squares in both directions with measured poses."""
    if recording.run is None or recording.run.side is None:
        return []
    rows: list[Number] = []
    for truck in recording.vehicle.trucks:
        try:
            errors = experiment_of_recordings([recording], truck).errors
        except CalibrationError:
            continue  # one direction alone, or no fixes
        rows.append((f"E_max,syst of truck {truck}", "m", errors.e_max_syst, None))
    return rows


def delete_recording(store: Files, results: Files, stored: StoredRecording) -> bool:
    """Delete a recording and its results; return whether there was anything of it.

    The daily report of its day goes where no other recording of that day has results, and the day goes from
    the robot's history where no other one of the robot has. What is left of an interrupted deletion goes by
    the next one.

    Raises:
        OSError: Files cannot be read or written.
    """
    files = store.glob(f"{escape(stored.path)}/*")
    tables = _result_paths(results, stored)
    # A recording without vehicle.toml is none, so that no batch takes up a part of one.
    for path in sorted(files, key=lambda path: not path.endswith(VEHICLE)):
        store.delete(path)
    for path in tables:
        results.delete(path)
    if not results.glob(f"recordings/{escape(stored.partition)}/*.parquet"):
        delete_history_day(results, stored.robot, stored.day)
    if not results.glob(f"recordings/robot=*/day={stored.day}/*.parquet"):
        delete_report(results, stored.day)
    return bool(files or tables)
