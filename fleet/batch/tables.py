"""The tables of the results: their columns, and their encoding as Parquet.

Equal results have equal bytes: a file contains neither the time nor the machine of its writing.
"""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

from omnimate.fleet.errors import FleetError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

# For each table its columns, each with type, and unit or meaning. `robot` and `day` are in the path only.
TABLES: dict[str, dict[str, tuple[str, str]]] = {
    "recordings": {
        "recording": ("string", "name"),
        "key": ("string", "of this result"),
        "recording_hash": ("string", "SHA-256 of log, poses and run"),
        "vehicle_hash": ("string", "SHA-256 of vehicle.toml"),
        "tool": ("string", "version of the software and of its results"),
        "kind": ("string", "type of the robot"),
        "floor": ("string", "on which it was driven, by run.toml; empty for the only one"),
        "start": ("double", "s"),
        "duration": ("double", "s"),
        "way": ("double", "m, travel of truck a"),
        "error": ("string", "why there is no more; null where nothing failed"),
        "triage": ("string", "agreement, mismatch or insufficient"),
        "probability": ("double", "that anything is there, by triage"),
        "effect": ("string", "that comes closest"),
        "component": ("string", "on which"),
        "says": ("string", "triage in a sentence"),
        "diagnosis": (
            "string",
            "the full one, of a minute with a linkage, as JSON; null where triage found no mismatch",
        ),
    },
    "numbers": {
        "recording": ("string", "name"),
        "name": ("string", "of the number"),
        "unit": ("string", "1, rad or m"),
        "value": ("double", "in that unit"),
        "sigma": ("double", "in that unit; null where none is known"),
    },
    "ways": {
        "recording": ("string", "name"),
        "way": ("int32", "number of the segment between two poses, from 0"),
        "time": ("double", "s, at its end"),
        "residual": ("double[3]", "m, m, rad: measured less odometry"),
        "jacobian": ("double[9]", "residual by left wheel, right wheel, wheelbase; row by row"),
        "rough": ("double[9]", "covariance of the residual for a roughness of 1 m/sqrt(m)"),
        "lever": ("double[2]", "m, end less start"),
        "sigma": ("double[6]", "m, m, rad of the first and of the last pose"),
        "follows": ("bool", "whether it begins with the last pose of the segment before"),
    },
    "crossings": {
        "recording": ("string", "name"),
        "way": ("int32", "number of the segment"),
        "x": ("int32", "number of the cell of 0.25 m"),
        "y": ("int32", "likewise"),
        "loss_x": ("float", "m: residual by the part of the travel that is lost in the cell"),
        "loss_y": ("float", "m"),
        "loss_theta": ("float", "rad"),
        "creep": ("float", "m: travel over the cell"),
    },
    "robots": {
        "robot": ("string", "name"),
        "kind": ("string", "type of the robot"),
        "listed": ("bool", "whether it is faulty"),
        "log_e": ("double", "logarithm of the evidence for a change"),
        "name": ("string", "number that changed most likely"),
        "share": ("double", "probability of this number, given a change"),
        "since": ("string", "date"),
        "earliest": ("string", "date, 5 %"),
        "latest": ("string", "date, 95 %"),
        "shape": ("string", "step or ramp"),
        "size": ("double", "1 or rad, until the last day"),
        "sigma": ("double", "1 or rad"),
        "per_day": ("double", "1 or rad per day; 0 for a step"),
    },
    "places": {
        "floor": ("string", "on which it is; empty for the only one"),
        "effect": ("string", "loss or creep"),
        "x": ("double", "m"),
        "y": ("double", "m"),
        "reach": ("double", "m, radius"),
        "xx": ("double", "m^2, variance of x"),
        "xy": ("double", "m^2"),
        "yy": ("double", "m^2"),
        "size": ("double[]", "part lost, or creep per metre along x and y"),
        "sigma": ("double[]", "likewise"),
        "gain": ("double", "twice the gain in log likelihood"),
        "crossings": ("int32", "number of segments over it"),
    },
    "asked": {
        "robot": ("string", "name, of a robot that is not faulty"),
        "effect": ("string", "of the mismatch that triage repeats"),
        "component": ("string", "on which"),
        "since": ("string", "date"),
    },
    "failed": {
        "robot": ("string", "name"),
        "recording": ("string", "name, of a recording of the day"),
        "error": ("string", "why it has no results"),
    },
    "floor": {
        "floor": ("string", "on which it is; empty for the only one"),
        "x": ("double", "m, middle of a cell that was driven over within the week"),
        "y": ("double", "m"),
        "count": ("int32", "number of segments over it"),
    },
    "nights": {
        "recordings": ("int32", "number of recordings of the day"),
        "roughness": ("double", "m/sqrt(m), of the floor with most recordings, outside its bad places"),
    },
    "floors": {
        "floor": ("string", "name; empty for the only one"),
        "recordings": ("int32", "number of recordings within the week"),
        "roughness": ("double", "m/sqrt(m), outside its bad places"),
    },
    "latest": {
        "day": ("string", "date of the latest report"),
    },
    "histories": {
        "day": ("string", "date"),
        "name": ("string", "of the number"),
        "unit": ("string", "1, or rad"),
        "value": ("double", "in that unit, relative to vehicle.toml, without the effect of bad places"),
        "sigma": ("double", "in that unit"),
    },
}


def encode_columns(table: str, columns: Mapping[str, Sequence[Any]]) -> bytes:
    """Return the Parquet file of a table; `columns` has the values of each of its columns.

    Raises:
        FleetError: pyarrow is not installed.
    """
    arrow, parquet = parquet_libraries()
    schema = arrow.schema(
        [
            arrow.field(name, _type(arrow, kind), metadata={"meaning": meaning})
            for name, (kind, meaning) in TABLES[table].items()
        ]
    )
    out = io.BytesIO()
    rows = arrow.table({name: columns[name] for name in TABLES[table]}, schema=schema)
    parquet.write_table(rows, out, compression="zstd")
    return out.getvalue()


def encode_rows(table: str, rows: Sequence[Mapping[str, Any]]) -> bytes:
    """Return the Parquet file of a table from its rows; keys that are no columns are ignored."""
    return encode_columns(table, {name: [row[name] for row in rows] for name in TABLES[table]})


def decode_columns(content: bytes) -> dict[str, Any]:
    """Return the columns of a Parquet file: strings and lists as Python lists, others as NumPy arrays."""
    table = _decode(content)
    return {
        name: column.to_pylist() if _is_object(column) else column.to_numpy()
        for name, column in zip(table.column_names, table.columns, strict=True)
    }


def decode_rows(content: bytes) -> list[dict[str, Any]]:
    """Return the rows of a Parquet file as dictionaries of Python values."""
    rows: list[dict[str, Any]] = _decode(content).to_pylist()
    return rows


def _decode(content: bytes) -> Any:  # noqa: ANN401 -- pyarrow has no types
    _, parquet = parquet_libraries()
    return parquet.ParquetFile(io.BytesIO(content)).read(use_threads=False)  # small: threads only wait


def _is_object(column: Any) -> bool:  # noqa: ANN401 -- likewise
    text = str(column.type)
    return text == "string" or "list" in text


def _type(arrow: Any, kind: str) -> Any:  # noqa: ANN401 -- likewise
    """Return the pyarrow type for a type in `TABLES`, such as `double[3]`."""
    word, _, size = kind.partition("[")
    plain = {
        "string": arrow.string(),
        "double": arrow.float64(),
        "float": arrow.float32(),
        "int32": arrow.int32(),
        "bool": arrow.bool_(),
    }[word]
    if not size:
        return plain
    return arrow.list_(plain, int(size[:-1])) if size != "]" else arrow.list_(plain)


def parquet_libraries() -> tuple[Any, Any]:
    """Return the modules `pyarrow` and `pyarrow.parquet`, which have no type hints.

    Raises:
        FleetError: pyarrow is not installed.
    """
    try:
        import pyarrow  # noqa: ICN001, PLC0415 -- an extra
        from pyarrow import parquet  # noqa: PLC0415 -- likewise
    except ImportError as error:
        raise FleetError("results", "Parquet needs pyarrow: pip install 'omnimate[fleet]'") from error
    return pyarrow, parquet
