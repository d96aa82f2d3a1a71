"""Tables of a mapping's TOML, read strictly: a wrong type or an unknown key is named with its file."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from imports.errors import MappingError

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator


class Table:
    """One table; every key that is asked for is ticked off, and `done` refuses the rest.

    Attributes:
        source: file and dotted key, for messages.
    """

    def __init__(self, values: dict[str, Any], source: str) -> None:
        self._values, self._asked = values, set[str]()
        self.source = source

    def __contains__(self, key: str) -> bool:
        return key in self._values

    def names(self) -> list[str]:
        """Return its keys, in order."""
        return list(self._values)

    def text(self, key: str, default: str | None = None, among: Collection[str] = ()) -> str:
        """Return a text; MappingError where it is none, or none of those expected."""
        value = self._take(key, default)
        if not isinstance(value, str) or (among and value not in among):
            raise self._error(key, value, f"one of {', '.join(among)}" if among else "text")
        return value

    def number(self, key: str, default: float | None = None) -> float:
        """Return a finite number; MappingError where it is none."""
        value = self._take(key, default)
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise self._error(key, value, "a finite number")
        return float(value)

    def switch(self, key: str, *, default: bool = False) -> bool:
        """Return true or false; MappingError where it is neither."""
        value = self._take(key, default)
        if not isinstance(value, bool):
            raise self._error(key, value, "true or false")
        return value

    def column(self, key: str) -> str | int:
        """Return a column's name, or its number counted from 1; MappingError where it is neither."""
        value = self._take(key, None)
        if isinstance(value, bool) or not isinstance(value, str | int):
            raise self._error(key, value, "a column's name, or its number counted from 1")
        return value

    def table(self, key: str) -> Table:
        """Return a table inside; an empty one where it is absent."""
        value = self._take(key, {})
        if not isinstance(value, dict):
            raise self._error(key, value, "a table")
        return Table(value, f"{self.source}: {key}")

    def tables(self, key: str, names: Collection[str]) -> Iterator[tuple[str, Table]]:
        """Yield the tables inside a table by their names; MappingError where a name is not expected."""
        outer = self.table(key)
        for name in outer.names():
            if name not in names:
                raise MappingError(outer.source, f"{name!r} is unknown; expected {', '.join(names)}")
            yield name, outer.table(name)

    def done(self) -> None:
        """Refuse keys that nobody asked for."""
        for key in self._values:
            if key not in self._asked:
                known = ", ".join(sorted(self._asked))
                raise MappingError(self.source, f"unknown key {key!r}; expected {known}")

    def _take(self, key: str, default: Any) -> Any:  # noqa: ANN401 - TOML values are of any type until checked
        self._asked.add(key)
        return self._values.get(key, default)

    def _error(self, key: str, value: object, expected: str) -> MappingError:
        if value is None:
            return MappingError(self.source, f"{key} is missing; expected {expected}")
        return MappingError(self.source, f"{key} = {value!r}; expected {expected}")


def read_table(path: Path | str) -> Table:
    """Return a TOML file as a table.

    Raises:
        MappingError: it cannot be read or is no TOML.
    """
    try:
        return Table(tomllib.loads(Path(path).read_text(encoding="utf-8-sig")), str(path))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise MappingError(path, f"cannot be read: {error}") from error
