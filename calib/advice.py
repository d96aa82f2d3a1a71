"""Advice about measurements that look wrong."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Severity = Literal["note", "warning", "error"]


@dataclass(frozen=True, slots=True)
class Advice:
    """One problem of the measurements, and its remedy.

    Attributes:
        severity: A "note" does no harm, a "warning" may, and after an "error" the result is not to be used.
        what: The problem.
        do: What to do about it.
    """

    severity: Severity
    what: str
    do: str

    def __str__(self) -> str:
        """Return the problem and the remedy in one sentence."""
        return f"{self.what}: {self.do}"
