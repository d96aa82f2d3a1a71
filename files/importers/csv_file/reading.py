"""A CSV file as cells, with its delimiter and its header recognised."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING

from omnimate.files.importers.csv_file.table import CsvTable
from omnimate.files.importers.errors import SourceError

if TYPE_CHECKING:
    from collections.abc import Iterable

DELIMITERS = {"tab": "\t", ";": ";", "|": "|", ",": ",", "space": " "}  # in the order in which they are tried
_COMMENTS = ("#", "%")
_LOOKED_AT = 20  # lines from which the delimiter is recognised


def read_csv_table(path: Path | str, delimiter: str = "", skip: int = 0) -> CsvTable:
    """Return the cells of a CSV file.

    Lines that begin with # or % are comments. A comment directly above the first row is the header if it has
    as many cells.

    Args:
        path: The CSV file.
        delimiter: A key of `DELIMITERS`; an empty one is recognised from the first lines.
        skip: Number of lines above the header that do not belong to the table.

    Raises:
        SourceError: The file cannot be read, is empty, or a row is longer or shorter than the others.
    """
    path = Path(path)
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise SourceError(path, f"cannot be read: {error}") from error
    numbered = [(number, line.strip(" ")) for number, line in enumerate(lines, start=1)]
    kept = [(number, line) for number, line in numbered[skip:] if line.strip()]
    data = [(number, line) for number, line in kept if not line.startswith(_COMMENTS)]
    if not data:
        raise SourceError(path, "empty; expected a header and rows of numbers")
    sign = DELIMITERS[delimiter] if delimiter else _delimiter(line for _, line in data[:_LOOKED_AT])
    rows = [_split(line, sign) for _, line in data]
    header = (
        rows.pop(0) if not any(map(_is_number, rows[0])) else _header_in_comment(kept, data[0], rows, sign)
    )
    return _checked(path, header, rows, [number for number, _ in data][-len(rows) :] if rows else [], sign)


def _checked(path: Path, header: list[str], rows: list[list[str]], lines: list[int], sign: str) -> CsvTable:
    if not rows:
        raise SourceError(path, "a header without rows; expected rows of numbers")
    width = len(header) or len(rows[0])
    for number, row in zip(lines, rows, strict=True):
        while len(row) > width and not row[-1].strip():
            row.pop()  # a delimiter at the end of the line
        if len(row) != width:
            raise SourceError(
                f"{path}:{number}", f"{len(row)} cell(s); expected {width} as in the first line"
            )
    return CsvTable(path, tuple(name.strip() for name in header), rows, lines, sign)


def _header_in_comment(
    kept: list[tuple[int, str]], first: tuple[int, str], rows: list[list[str]], sign: str
) -> list[str]:
    place = kept.index(first)
    if place == 0:
        return []
    names = _split(kept[place - 1][1].lstrip("#% "), sign)
    return names if len(names) == len(rows[0]) else []


def _split(line: str, sign: str) -> list[str]:
    return next(csv.reader([line], delimiter=sign, skipinitialspace=True), [])


def _delimiter(lines: Iterable[str]) -> str:
    """Return the first delimiter that is in every line; a comma where none is."""
    seen = list(lines)
    return next((sign for sign in DELIMITERS.values() if all(sign in line for line in seen)), ",")


def _is_number(cell: str) -> bool:
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return False
    return True
