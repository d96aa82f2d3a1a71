"""Tables as Parquet: one row for each sample, pose, event or frame. Units stand in the columns' metadata.

Only this file uses the library `pyarrow`, which is optional.
"""

from __future__ import annotations

from itertools import islice
from typing import TYPE_CHECKING, Any

import numpy as np

from omnimate.files.exporters.messages import channel_values
from omnimate.files.logs.frames import BRS, ERROR, ESI, EXTENDED, FD, RECEIVED, REMOTE, SENT

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path as FilePath

    from omnimate.files.exporters.drive import Drive
    from omnimate.files.logs.frames import Frame

ROW_GROUP_FRAMES = 1 << 16  # frames in memory, and in a group of rows
_AXES = (("x", "m"), ("y", "m"), ("theta", "rad"))
_KINDS = {"extended": EXTENDED, "remote": REMOTE, "error": ERROR, "fd": FD, "brs": BRS, "esi": ESI}


def write_parquet(drive: Drive, target: FilePath) -> tuple[FilePath, ...]:
    """Write samples, and beside them measured poses and events where there are any; return the files.

    `drive.parquet` has the samples; `drive-poses.parquet` and `drive-events.parquet` the others.
    """
    tables = {"": _samples(drive), "-poses": _poses(drive), "-events": _events(drive)}
    written = []
    for ending, columns in tables.items():
        if columns:
            path = target.with_name(f"{target.stem}{ending}{target.suffix}")
            _write(columns, path)
            written.append(path)
    return tuple(written)


def write_frames(frames: Iterable[Frame], path: FilePath) -> None:
    """Write a table of frames, `ROW_GROUP_FRAMES` of them at a time."""
    arrow, parquet = _libraries()
    schema = arrow.schema(
        [
            arrow.field("time", arrow.float64(), metadata={"unit": "s"}),
            arrow.field("channel", arrow.dictionary(arrow.int32(), arrow.string())),
            arrow.field("can_id", arrow.uint32()),
            *(arrow.field(name, arrow.bool_()) for name in _KINDS),
            arrow.field("is_sent", arrow.bool_()),
            arrow.field("length", arrow.uint8()),
            arrow.field("data", arrow.binary()),
        ]
    )
    remaining = iter(frames)
    with parquet.ParquetWriter(path, schema) as writer:
        while rows := list(islice(remaining, ROW_GROUP_FRAMES)):
            writer.write_table(arrow.table(_frame_columns(rows), schema=schema))


def _frame_columns(rows: list[Frame]) -> dict[str, list[Any]]:
    columns: dict[str, list[Any]] = {
        "time": [row.time for row in rows],
        "channel": [row.channel for row in rows],
        "can_id": [row.can_id for row in rows],
    }
    columns |= {name: [bool(row.flags & bit) for row in rows] for name, bit in _KINDS.items()}
    directions = {0: None, SENT: True, RECEIVED: False}
    columns["is_sent"] = [directions.get(row.flags & (SENT | RECEIVED)) for row in rows]
    columns["length"] = [row.size for row in rows]
    columns["data"] = [row.data for row in rows]
    return columns


Columns = dict[str, tuple[Any, str]]  # values and unit of each column; nan stands for what is not known


def _samples(drive: Drive) -> Columns:
    recording = drive.recording
    columns: Columns = {"time": (recording.time, "s")}
    for channel in recording.vehicle.channels:
        present = recording.is_present(channel)
        unit = "m" if channel == "link" else "rad"
        columns[f"{channel}.present"] = (present, "")
        columns[f"{channel}.counts"] = (recording.channel_counts(channel), "counts")
        columns[str(channel)] = (np.where(present, channel_values(recording, channel), np.nan), unit)
    if recording.commands is not None:
        for number, wheel in enumerate(recording.vehicle.wheels):
            columns[f"{wheel}.command"] = (recording.commands[:, number], "rad/s")
    for path in drive.paths:
        for number, (axis, unit) in enumerate(_AXES):
            columns[f"{path.name}.{axis}"] = (path.pose[:, number], unit)
    return columns


def _poses(drive: Drive) -> Columns:
    poses = drive.recording.poses
    if poses is None or not len(poses.time):
        return {}
    columns: Columns = {"time": (poses.time, "s"), "body": (poses.body.tolist(), "")}
    for number, (axis, unit) in enumerate(_AXES):
        columns[axis] = (poses.pose[:, number], unit)
        columns[f"sigma_{axis}"] = (poses.sigma[:, number], unit)
    return columns


def _events(drive: Drive) -> Columns:
    if not drive.events:
        return {}
    return {
        "time": ([event.time for event in drive.events], "s"),
        "node": ([event.node for event in drive.events], ""),
        "what": ([event.what for event in drive.events], ""),
        "is_problem": ([event.is_problem for event in drive.events], ""),
    }


def _write(columns: Columns, path: FilePath) -> None:
    arrow, parquet = _libraries()
    arrays = [arrow.array(values, from_pandas=True) for values, _ in columns.values()]
    fields = [
        arrow.field(name, array.type, metadata={"unit": unit} if unit else None)
        for (name, (_, unit)), array in zip(columns.items(), arrays, strict=True)
    ]
    parquet.write_table(arrow.table(arrays, schema=arrow.schema(fields)), path)


def _libraries() -> tuple[Any, Any]:
    """Return pyarrow and its module of Parquet, which have no types."""
    import pyarrow  # noqa: ICN001, PLC0415 -- an extra; few need it
    from pyarrow import parquet  # noqa: PLC0415 -- likewise

    return pyarrow, parquet
