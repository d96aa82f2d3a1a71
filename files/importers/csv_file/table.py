"""The cells of a CSV file as columns of numbers; errors name file, line and column."""

from __future__ import annotations

import math
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import TYPE_CHECKING

import numpy as np

from omnimate.files.importers.errors import SourceError

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from omnimate.vehicle.se2 import Array


@dataclass(frozen=True, slots=True)
class CsvTable:
    """The cells of a CSV file.

    Attributes:
        path: The file.
        header: Names of the columns; empty where the file has none.
        rows: Cells of each row; all rows have the same length.
        lines: Number of the line of each row in the file, counted from 1.
        delimiter: Character between cells.
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
        cells = self._cells(column)
        return self._converted(cells, column, float)

    def moments(self, column: str | int) -> Array:
        """Return a column of ISO 8601 dates and times [s since 1970], shape `(N,)`; UTC without a time zone.

        Raises:
            SourceError: There is no such column, or a cell is not a date and time.
        """
        return self._converted(self._cells(column), column, _moment)

    def _cells(self, column: str | int) -> list[str]:
        number = self._number(column)
        return [row[number].strip() for row in self.rows]

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

    def _converted(self, cells: list[str], column: str | int, convert: Callable[[str], float]) -> Array:
        values = np.empty(len(cells))
        for row, cell in enumerate(cells):
            try:
                values[row] = convert(self._plain(cell)) if cell else math.nan
            except ValueError as error:
                raise SourceError(self.place(row, column), f"{cell!r} is no {_noun(convert)}") from error
            if cell and not math.isfinite(values[row]):
                raise SourceError(
                    self.place(row, column), f"{cell!r}; expected a finite number, or nothing where unknown"
                )
        return values

    def _plain(self, cell: str) -> str:
        return cell if self.delimiter == "," else cell.replace(",", ".")


def _tidy(name: str) -> str:
    return " ".join(name.strip().strip("#%\"' ").lower().split())


def _without_unit(name: str) -> str:
    return _tidy(name.split("[", maxsplit=1)[0].split("(", maxsplit=1)[0])


def _moment(cell: str) -> float:
    moment = datetime.fromisoformat(cell)
    return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()


def _noun(convert: object) -> str:
    return "number" if convert is float else "date and time of ISO 8601"
