"""The work on one recording: its results as tables, written once, whole, and under their key."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from omnimate.calib.errors import CalibrationError
from omnimate.calib.umbmark.experiment import experiment_of_recordings
from omnimate.files.recordings.folder import load_recording
from omnimate.fleet.batch.files import open_files
from omnimate.fleet.batch.part import part_of
from omnimate.fleet.batch.store import folder_of
from omnimate.fleet.batch.tables import TABLES, parquet_bytes
from omnimate.fleet.crossings import crossings_of
from omnimate.fleet.joints import JOINT_NUMBERS, joints_of
from omnimate.fleet.model.days import kind_of
from omnimate.fleet.segments import PARAMETERS, segments_of
from omnimate.mismatch import diagnose
from omnimate.mismatch.triage.triage import triage
from omnimate.vehicle.errors import OmnimateError
from omnimate.vehicle.floor import CONCRETE_ROUGHNESS
from omnimate.vehicle.odometry import truck_travel

if TYPE_CHECKING:
    from pathlib import Path

    from omnimate.fleet.batch.files import Files
    from omnimate.fleet.batch.store import StoredRecording
    from omnimate.fleet.segments import Segments, Steps
    from omnimate.vehicle.recording import Recording

Status = Literal["done", "known"]
Columns = dict[str, Any]
OF_RECORDINGS = ("crossings", "ways", "numbers", "recordings")  # the last one says that all are there
_FEWEST = 2  # ways from which on a recording says something of its robot


def work_on(store: str, results: str, stored: StoredRecording, *, diagnosed: bool) -> Status:
    """Make the results of one recording, unless they are known.

    Args:
        store: Folder or URL of the store.
        results: Folder or URL of the results.
        stored: The recording.
        diagnosed: Whether the whole diagnosis is made where triage asks for it.

    Raises:
        FleetError: A library is missing.
        OSError: Files cannot be read or written.
    """
    target = open_files(results)
    with folder_of(open_files(store), stored) as (folder, version):
        key = version.key(diagnosed=diagnosed)
        if target.glob(_path("recordings", stored, key)):
            return "known"
        tables = _tables(folder, diagnosed=diagnosed)
    tables["recordings"] |= {
        "key": [key],
        "recording_hash": [version.recording],
        "vehicle_hash": [version.vehicle],
        "tool": [version.tool],
    }
    for table in OF_RECORDINGS:
        columns = {"recording": [stored.name] * _length(tables[table]), **tables[table]}
        target.write(_path(table, stored, key), parquet_bytes(table, columns))
    _forget_others(target, stored, key)
    return "done"


def _path(table: str, stored: StoredRecording, key: str) -> str:
    return f"{table}/{stored.place}/{stored.name}-{key}.parquet"


def _forget_others(target: Files, stored: StoredRecording, key: str) -> None:
    """Delete results of the same recording from before it, its vehicle or the software changed."""
    for table in OF_RECORDINGS:
        for path in target.glob(_path(table, stored, "*")):
            if path != _path(table, stored, key):
                target.delete(path)


def _length(columns: Columns) -> int:
    return len(next(iter(columns.values())))


def _empty(table: str) -> Columns:
    return {name: [] for name in TABLES[table] if name != "recording"}


def _tables(folder: Path, *, diagnosed: bool) -> dict[str, Columns]:
    """Return the tables of a recording; where it cannot be worked on, one row that says why."""
    tables = {table: _empty(table) for table in OF_RECORDINGS}
    row: Columns = dict.fromkeys(tables["recordings"])
    try:
        recording = load_recording(folder)
        row |= _drive(recording)
        cut = segments_of(recording)
        tables["numbers"] = _numbers(recording, cut[0] if cut else None)
        if cut:
            tables["ways"], tables["crossings"] = _ways(cut[0]), _crossings(cut[1])
        row |= _asked(recording, diagnosed=diagnosed)
    except OmnimateError as error:
        row["error"] = str(error).replace(str(folder), folder.name)
    tables["recordings"] = {name: [value] for name, value in row.items()}
    return tables


def _drive(recording: Recording) -> Columns:
    left, right, _ = truck_travel(recording, "a")
    return {
        "kind": kind_of(recording.vehicle),
        "floor": recording.run.floor if recording.run else "",
        "start": float(recording.time[0]),
        "duration": float(recording.time[-1] - recording.time[0]),
        "way": float(np.abs(np.diff(0.5 * (left + right))).sum()),
    }


def _asked(recording: Recording, *, diagnosed: bool) -> Columns:
    """Return what triage says, and the whole diagnosis where it asks for it."""
    answer = triage([recording])
    closest = answer.closest[0] if answer.closest else None
    whole = None
    if diagnosed and answer.verdict == "mismatch":
        found = diagnose([part_of(recording, answer.where)]).as_json()
        whole = json.dumps(found, sort_keys=True).replace(
            recording.source, recording.source.rpartition("/")[2]
        )
    return {
        "triage": answer.verdict,
        "probability": answer.probability,
        "effect": closest.effect if closest else None,
        "component": closest.component if closest else None,
        "says": answer.says,
        "diagnosis": whole,
    }


def _numbers(recording: Recording, segments: Segments | None) -> Columns:
    """Return the numbers of a recording: parameters beside the file, joints, and UMBmark of squares."""
    rows: list[tuple[str, str, float, float | None]] = []
    if segments is not None and len(segments) >= _FEWEST:
        jacobian = segments.jacobian.reshape(-1, len(PARAMETERS))
        weighed = np.linalg.solve(segments.covariance(CONCRETE_ROUGHNESS), jacobian)
        covariance = np.linalg.pinv(jacobian.T @ weighed)
        fitted = covariance @ (weighed.T @ segments.residual.reshape(-1))
        sigmas = np.sqrt(np.diag(covariance))
        rows += [
            (name, "1", value, sigma)
            for name, value, sigma in zip(PARAMETERS, fitted.tolist(), sigmas.tolist(), strict=True)
        ]
    joints = joints_of(recording)
    rows += [
        (name, "rad", value, sigma)
        for name, value, sigma in zip(
            JOINT_NUMBERS, joints.bias.tolist(), joints.sigma.tolist(), strict=False
        )
    ]
    rows += _umbmark(recording)
    names = "name", "unit", "value", "sigma"
    return dict(zip(names, map(list, zip(*rows, strict=True)), strict=True)) if rows else _empty("numbers")


def _umbmark(recording: Recording) -> list[tuple[str, str, float, float | None]]:
    """Return E_max,syst of each truck whose squares were driven in both directions with fixes around them."""
    if recording.run is None or recording.run.side is None:
        return []
    rows: list[tuple[str, str, float, float | None]] = []
    for truck in recording.vehicle.trucks:
        try:
            errors = experiment_of_recordings([recording], truck).errors
        except CalibrationError:
            continue  # one direction alone, or no fixes: nothing to say of squares
        rows.append((f"E_max,syst of truck {truck}", "m", errors.e_max_syst, None))
    return rows


def _ways(segments: Segments) -> Columns:
    count = len(segments)
    return {
        "way": np.arange(count, dtype=np.int32),
        "time": segments.time,
        "residual": segments.residual.tolist(),
        "jacobian": segments.jacobian.reshape(count, 9).tolist(),
        "rough": segments.rough.reshape(count, 9).tolist(),
        "lever": segments.lever.tolist(),
        "sigma": segments.sigma.reshape(count, 6).tolist(),
        "follows": segments.follows,
    }


def _crossings(steps: Steps) -> Columns:
    crossings = crossings_of(steps)
    return {
        "way": crossings.way,
        "x": np.ascontiguousarray(crossings.cell[:, 0]),
        "y": np.ascontiguousarray(crossings.cell[:, 1]),
        "loss_x": crossings.loss[:, 0].astype(np.float32),
        "loss_y": crossings.loss[:, 1].astype(np.float32),
        "loss_theta": crossings.loss[:, 2].astype(np.float32),
        "creep": crossings.creep.astype(np.float32),
    }
