"""How a study says how far it is; the command line shows a bar."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager

Report = Callable[[int, int], None]  # called with how much is done, and of how much
Progress = Callable[[str], AbstractContextManager[Report]]  # called with what is being done
