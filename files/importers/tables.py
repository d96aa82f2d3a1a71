"""Tables of a mapping in TOML, read strictly: errors name the file and the key."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from omnimate.files.errors import MappingError
from omnimate.vehicle.errors import describe_read_error

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator

Name = TypeVar("Name", bound=str)


class Table:
    """A table that records the keys that were read; `done` raises an error for all others.

    Attributes:
        source: File and dotted key, for messages.

    Raises:
        MappingError: By every method, where a value is not what it expects.
    """

    def __init__(self, values: dict[str, Any], source: str) -> None:
        self._values, self._read = values, set[str]()
        self.source = source

    def __contains__(self, key: str) -> bool:
        return key in self._values

    def names(self) -> list[str]:
        """Return the keys in their order."""
        return list(self._values)

    def text(self, key: str, default: str | None = None, among: Collection[str] = ()) -> str:
        """Return a text."""
        value = self._take(key, default)
        if not isinstance(value, str) or (among and value not in among):
            raise self._error(key, value, f"one of {', '.join(among)}" if among else "text")
        return value

    def number(self, key: str, default: float | None = None) -> float:
        """Return a finite number."""
        value = self._take(key, default)
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise self._error(key, value, "a finite number")
        return float(value)

    def switch(self, key: str) -> bool:
        """Return true or false; false where it is absent."""
        value = self._take(key, False)
        if not isinstance(value, bool):
            raise self._error(key, value, "true or false")
        return value

    def column(self, key: str) -> str | int:
        """Return a column's name, or its number counted from 1."""
        value = self._take(key, None)
        if isinstance(value, bool) or not isinstance(value, str | int):
            raise self._error(key, value, "a column's name, or its number counted from 1")
        return value

    def table(self, key: str) -> Table:
        """Return an inner table; an empty one where it is absent."""
        value = self._take(key, {})
        if not isinstance(value, dict):
            raise self._error(key, value, "a table")
        return Table(value, f"{self.source}: {key}")

    def tables(self, key: str, names: Collection[Name]) -> Iterator[tuple[Name, Table]]:
        """Yield the tables inside an inner table, with their names, which are among those expected."""
        outer = self.table(key)
        for name in outer.names():
            known = next((known for known in names if known == name), None)
            if known is None:
                raise MappingError(outer.source, f"{name!r} is unknown; expected {', '.join(names)}")
            yield known, outer.table(name)

    def done(self) -> None:
        """Raise an error for keys that were not read."""
        for key in self._values:
            if key not in self._read:
                known = ", ".join(sorted(self._read))
                raise MappingError(self.source, f"unknown key {key!r}; expected {known}")

    def _take(self, key: str, default: Any) -> Any:  # noqa: ANN401 - TOML values are of any type until checked
        self._read.add(key)
        return self._values.get(key, default)

    def _error(self, key: str, value: object, expected: str) -> MappingError:
        if value is None:
            return MappingError(self.source, f"{key} is missing; expected {expected}")
        return MappingError(self.source, f"{key} = {value!r}; expected {expected}")


def read_table(path: Path | str) -> Table:
    """Return a TOML file as a table.

    Raises:
        MappingError: The file cannot be read or is not TOML.
    """
    try:
        return Table(tomllib.loads(Path(path).read_text(encoding="utf-8-sig")), str(path))
    except (OSError, UnicodeDecodeError) as error:
        raise MappingError(path, f"cannot be read: {describe_read_error(error)}") from error
    except tomllib.TOMLDecodeError as error:
        raise MappingError(path, f"cannot be read: {error}") from error
