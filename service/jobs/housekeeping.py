"""What every service does regularly in the database that it may share, however long its jobs take."""

from __future__ import annotations

from typing import TYPE_CHECKING

from omnimate.service.jobs.queue import expire_sessions_and_requeue_jobs
from omnimate.service.threads import RepeatingThread

if TYPE_CHECKING:
    from collections.abc import Callable

    from omnimate.service.store.database import Database


class Housekeeper(RepeatingThread):
    """The thread that expires sessions, and ends what services that have died have left behind."""

    def __init__(self, database: Database, announce: Callable[[str], None]) -> None:
        super().__init__("housekeeping")
        self._database, self._announce = database, announce

    def work(self) -> bool:
        """Do it once, and announce the sessions that are interrupted by it."""
        for session in expire_sessions_and_requeue_jobs(self._database):
            self._announce(session)
        return False
