"""The cells of a CSV file, with delimiter and header recognised; errors name file, line and column."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from omnimate.files.errors import SourceError
from omnimate.vehicle.errors import describe_read_error

if TYPE_CHECKING:
    from collections.abc import Callable

    from omnimate.vehicle.se2 import Array

DELIMITERS = {"tab": "\t", ";": ";", "|": "|", ",": ",", "space": " "}  # in the order in which they are tried
_COMMENTS = ("#", "%")
_DETECTION_LINES = 20  # lines from which the delimiter is recognised


@dataclass(frozen=True, slots=True)
class CsvTable:
    """The cells of a CSV file.

    The header is empty where the file has none; all rows have the same length; `lines` are the rows' lines in
    the file, counted from 1.
    """

    path: Path
    header: tuple[str, ...]
    rows: list[list[str]]
    lines: list[int]
    delimiter: str

    def place(self, row: int, column: str | int) -> str:
        """Return file, line and column of a cell, for messages."""
        return f"{self.path}:{self.lines[row]}: column {column}"

    def numbers(self, column: str | int) -> Array:
        """Return a column `(N,)`; nan where a cell is empty.

        Raises:
            SourceError: There is no such column, or a cell is not a finite number.
        """
        return self._converted(column, float, "number")

    def moments(self, column: str | int) -> Array:
        """Return a column of ISO 8601 dates and times [s since 1970], shape `(N,)`; UTC without a time zone.

        Raises:
            SourceError: There is no such column, or a cell is not a date and time.
        """
        return self._converted(column, _moment, "date and time of ISO 8601")

    def _number(self, column: str | int) -> int:
        width = len(self.rows[0])
        if isinstance(column, int):
            if 1 <= column <= width:
                return column - 1
            raise SourceError(self.path, f"no column {column}; its columns are 1 to {width}")
        for plain in (_tidy, _without_unit):
            fits = [place for place, name in enumerate(self.header) if plain(name) == plain(column)]
            if len(fits) == 1:
                return fits[0]
            if fits:
                raise SourceError(self.path, f"column {column!r} stands {len(fits)} times; name it by number")
        names = ", ".join(self.header) if self.header else f"no header; name columns by number, 1 to {width}"
        raise SourceError(self.path, f"no column {column!r}; the file has: {names}")

    def _converted(self, column: str | int, convert: Callable[[str], float], noun: str) -> Array:
        number = self._number(column)
        values = np.full(len(self.rows), np.nan)
        for row, cells in enumerate(self.rows):
            cell = cells[number].strip()
            if not cell:
                continue
            try:
                values[row] = convert(cell if self.delimiter == "," else cell.replace(",", "."))
            except ValueError as error:
                raise SourceError(self.place(row, column), f"{cell!r} is no {noun}") from error
            if not math.isfinite(values[row]):
                raise SourceError(
                    self.place(row, column), f"{cell!r}; expected a finite number, or nothing where unknown"
                )
        return values


def _tidy(name: str) -> str:
    return " ".join(name.strip().strip("#%\"' ").lower().split())


def _without_unit(name: str) -> str:
    return _tidy(name.split("[", maxsplit=1)[0].split("(", maxsplit=1)[0])


def _moment(cell: str) -> float:
    moment = datetime.fromisoformat(cell)
    return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()


def read_csv_table(path: Path | str, delimiter: str = "", skip: int = 0) -> CsvTable:
    """Return the cells of a CSV file.

    Lines that begin with # or % are comments. A comment directly above the first row is the header if it has
    as many cells.

    The delimiter is a key of `DELIMITERS`, or recognised from the first lines; `skip` lines above the header
    do not belong to the table.

    Raises:
        SourceError: The file cannot be read, is empty, or a row is longer or shorter than the others.
    """
    path = Path(path)
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise SourceError(path, f"cannot be read: {describe_read_error(error)}") from error
    numbered = [(number, line.strip(" ")) for number, line in enumerate(lines, start=1)]
    kept = [(number, line) for number, line in numbered[skip:] if line.strip()]
    data = [(number, line) for number, line in kept if not line.startswith(_COMMENTS)]
    if not data:
        raise SourceError(path, "empty; expected a header and rows of numbers")
    sign = DELIMITERS[delimiter] if delimiter else _delimiter([line for _, line in data[:_DETECTION_LINES]])
    numbers, rows = [number for number, _ in data], [_split(line, sign) for _, line in data]
    if any(map(_is_number, rows[0])):
        above = kept[max(0, kept.index(data[0]) - 1)][1]
        header = _split(above.lstrip("#% "), sign) if above.startswith(_COMMENTS) else []
        header = header if len(header) == len(rows[0]) else []
    else:
        header = rows.pop(0)
    if not rows:
        raise SourceError(path, "a header without rows; expected rows of numbers")
    numbers, width = numbers[-len(rows) :], len(header) or len(rows[0])
    for number, row in zip(numbers, rows, strict=True):
        while len(row) > width and not row[-1].strip():
            row.pop()  # a delimiter at the end of the line
        if len(row) != width:
            raise SourceError(
                f"{path}:{number}", f"{len(row)} cell(s); expected {width} as in the first line"
            )
    return CsvTable(path, tuple(name.strip() for name in header), rows, numbers, sign)


def _split(line: str, sign: str) -> list[str]:
    return next(csv.reader([line], delimiter=sign, skipinitialspace=True), [])


def _delimiter(lines: list[str]) -> str:
    """Return the first delimiter that is in every line; a comma where none is."""
    return next((sign for sign in DELIMITERS.values() if all(sign in line for line in lines)), ",")


def _is_number(cell: str) -> bool:
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return False
    return True
