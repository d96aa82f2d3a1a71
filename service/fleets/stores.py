"""The stores of the fleets: recordings by robot and day, and their results."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.fleet.batch.files import open_files
from omnimate.service.errors import StateError
from omnimate.service.store.tables import FleetRow

if TYPE_CHECKING:
    from sqlalchemy.orm import Session

    from omnimate.fleet.batch.files import Files


class Stores:
    """The folder or URL under which each fleet has its store.

    Args:
        root: The folder or URL.
    """

    def __init__(self, root: str) -> None:
        self._root = root.rstrip("/")

    def store(self, fleet: str) -> str:
        """Return the folder or URL of a fleet's recordings, as `omnimate fleet run` takes it."""
        return f"{self._root}/{fleet}"

    def results(self, fleet: str) -> str:
        """Return the folder or URL of a fleet's results."""
        return f"{self.store(fleet)}/results"

    def recordings_of(self, fleet: str) -> Files:
        """Return the files of a fleet's recordings."""
        return open_files(self.store(fleet))

    def results_of(self, fleet: str) -> Files:
        """Return the files of a fleet's results."""
        return open_files(self.results(fleet))


def add_fleet(db: Session, name: str, now: float) -> FleetRow:
    """Add a fleet.

    Raises:
        StateError: there is a fleet of this name already.
    """
    if db.get(FleetRow, name) is not None:
        raise StateError(f"fleet {name!r} exists already")
    row = FleetRow(id=name, created=now)
    db.add(row)
    return row
