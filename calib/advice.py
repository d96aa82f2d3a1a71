"""Advice about measurements that look wrong."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Severity = Literal["note", "warning", "error"]


@dataclass(frozen=True, slots=True)
class Advice:
    """One problem of the measurements, and its remedy."""

    severity: Severity  # a "note" is harmless, a "warning" may matter, an "error" makes the result unusable
    what: str
    do: str  # remedy

    def __str__(self) -> str:
        """Return the problem and the remedy in one sentence."""
        return f"{self.what}: {self.do}"
