"""The client: the service's operations, and waiting for what they start."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, TypeVar

from omnimate.client.models import Batch, Job
from omnimate.client.operations import Operations
from omnimate.client.transport import Transport

if TYPE_CHECKING:
    import ssl
    from collections.abc import Callable

AnyJob = TypeVar("AnyJob", Job, Batch)
UNFINISHED = {"queued", "running"}


class Client(Operations):
    """A client of a service. Threads may share it.

    Operations are methods of its groups: `client.vehicles.get_vehicle("omnimate")`. Each raises
    `ProblemError` where the service refuses the call, and `UnreachableError` where there is no answer. An
    operation that changes something gets an Idempotency-Key of its own where none is given, so that it is
    carried out once, also where it has to be repeated. A list yields the items of all its pages, and
    requests a page when it is needed.

    Args:
        url: The address of the service, such as `http://127.0.0.1:8080`.
        key: The API key; None where the service asks for none.
        timeout: The longest time to wait for a part of an answer [s].
        patience: The longest time for which a call is repeated [s], where the service asks for that (429 or
            503 with Retry-After) or an answer was lost; 0 for never.
        context: Certificates for https; None for those of the system.

    Raises:
        UrlError: the address is neither http nor https.
    """

    def __init__(
        self,
        url: str,
        key: str | None = None,
        *,
        timeout: float = 150.0,  # the service reads an upload for two minutes at most
        patience: float = 60.0,
        context: ssl.SSLContext | None = None,
    ) -> None:
        super().__init__(Transport(url, key, timeout, patience, context))

    def wait(
        self, job: AnyJob, progress: Callable[[AnyJob], object] | None = None, every: float = 1.0
    ) -> AnyJob:
        """Wait for a diagnosis or a batch; return it when it is done, failed or cancelled (`state`).

        Args:
            job: The job, as it was started.
            progress: Called with the job each time that its state, progress or step has changed.
            every: The time between two calls [s].

        Raises:
            ProblemError: the service refused a call.
            UnreachableError: there was no answer.
        """
        shown = None
        while True:
            changed = job["state"], job["progress"], job["doing"]
            if progress is not None and changed != shown:
                progress(job)
            shown = changed
            if job["state"] not in UNFINISHED:
                return job
            time.sleep(every)
            job = self._again(job)

    def _again(self, job: AnyJob) -> AnyJob:
        """Return a job as it is now."""
        if job["kind"] == "batch":
            return self.fleets.get_batch(job["fleet"], job["id"])
        return self.diagnoses.get_diagnosis(job["id"])
