"""The batch: all recordings of a store, in this process or by the workers of Dask.

A result depends only on its recording and the software, is written in one step, and is identified by its key.
A worker may therefore fail at any time, a recording may be processed twice, and the batch may be restarted;
the results are the same.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnimate.fleet.batch.files import open_files
from omnimate.fleet.batch.store import recordings_in
from omnimate.fleet.batch.tables import parquet_libraries
from omnimate.fleet.batch.work import process_recording
from omnimate.fleet.errors import FleetError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from omnimate.fleet.batch.store import StoredRecording
    from omnimate.fleet.batch.work import Processed

RETRIES = 3  # further attempts for a recording whose files could not be read, or whose worker ended
MEMORY = "1.5GiB"  # memory limit of a worker, which processes one recording at a time


@dataclass(frozen=True, slots=True)
class Workers:
    """The processes of a batch.

    Jobs are processes on this machine, 1 for this one alone; the scheduler is an address of Dask, such as
    `tcp://10.0.0.1:8786`; a worker on this machine that exceeds the memory is restarted.
    """

    jobs: int = 1
    scheduler: str | None = None
    memory: str = MEMORY


@dataclass(frozen=True, slots=True)
class BatchResult:
    """The outcome of a batch.

    `done` recordings were processed, `known` ones had results already; `failed` have none, `unreadable` of
    both cannot be read, each with the reason; `undated` are folders whose day is no date, and which are left
    out.
    """

    done: int
    known: int
    failed: tuple[tuple[StoredRecording, str], ...]
    unreadable: tuple[tuple[StoredRecording, str], ...]
    undated: tuple[str, ...]


Outcome = tuple["StoredRecording", "Processed | Exception"]


def run_batch(
    store: str,
    results: str,
    *,
    day: str | None = None,
    diagnosed: bool = True,
    workers: Workers | None = None,
    progress: Callable[[int, int], object] = lambda _done, _total: None,
) -> BatchResult:
    """Process all recordings of a store whose results do not exist yet.

    A store is a folder or a URL. Without a day, YYYY-MM-DD, all are processed; `diagnosed`: recordings with a
    mismatch by triage are diagnosed, too. `progress` is called with (recordings processed, number of
    recordings).

    Raises:
        FleetError: The store has no recording, a library is missing, or Dask does not start.
    """
    parquet_libraries()  # names a missing extra before anything is computed
    recordings, undated = recordings_in(open_files(store), day or "*")
    workers = workers or Workers()
    if workers.jobs == 1 and workers.scheduler is None:
        outcomes = _in_process(store, results, recordings, diagnosed)
    else:
        outcomes = _by_dask(store, results, recordings, diagnosed, workers)
    counts, failed, unreadable = {"done": 0, "known": 0}, [], []
    for number, (stored, outcome) in enumerate(outcomes, start=1):
        if isinstance(outcome, Exception):
            failed.append((stored, f"{type(outcome).__name__}: {outcome}"))
        else:
            counts[outcome.status] += 1
            if outcome.error is not None:
                unreadable.append((stored, outcome.error))
        progress(number, len(recordings))
    return BatchResult(
        counts["done"], counts["known"], tuple(sorted(failed)), tuple(sorted(unreadable)), undated
    )


def _in_process(
    store: str, results: str, recordings: Sequence[StoredRecording], diagnosed: bool
) -> Iterator[Outcome]:
    for stored in recordings:
        try:
            yield stored, process_recording(store, results, stored, diagnosed=diagnosed)
        except FleetError:
            raise  # a problem of the call, such as a missing library, not of the recording
        except Exception as error:  # noqa: BLE001 -- the other recordings are processed
            yield stored, error


def _by_dask(
    store: str, results: str, recordings: Sequence[StoredRecording], diagnosed: bool, workers: Workers
) -> Iterator[Outcome]:
    """Yield the outcome of each recording, in the order of completion."""
    try:
        import distributed  # noqa: PLC0415 -- an extra
    except ImportError as error:
        raise FleetError(
            "workers", "several processes or a scheduler need Dask: pip install 'omnimate[cluster]'"
        ) from error
    try:
        client = distributed.Client(**_cluster(workers))
    except (OSError, ValueError) as error:  # of Dask, which reads addresses and sizes
        expected = "expected a running scheduler such as tcp://10.0.0.1:8786, or memory such as 1.5GiB"
        raise FleetError("workers", f"Dask has not started: {error}; {expected}") from error
    with client:
        futures = {
            client.submit(
                process_recording, store, results, stored, diagnosed=diagnosed, pure=False, retries=RETRIES
            ): stored
            for stored in recordings
        }
        for future in distributed.as_completed(list(futures)):
            failure = future.exception()
            yield futures[future], future.result() if failure is None else failure


def _cluster(workers: Workers) -> dict[str, object]:
    """Return the arguments of `distributed.Client`: the scheduler's address, or new local processes."""
    if workers.scheduler is not None:
        return {"address": workers.scheduler}
    return {
        "n_workers": workers.jobs,
        "threads_per_worker": 1,
        "processes": True,
        "memory_limit": workers.memory,
        "dashboard_address": "127.0.0.1:0",  # any free port: the default one may be in use
        "silence_logs": logging.CRITICAL,  # errors are returned with their recordings
    }
