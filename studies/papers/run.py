"""The stages of the reproduction, computed in this process or in several at once."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from studies.papers.rows import Row
    from studies.papers.table import Stage


def run(plan: Sequence[Stage], jobs: int) -> Iterator[tuple[str, tuple[Row, ...]]]:
    """Yield the name and the rows of each stage as soon as it is computed.

    Args:
        plan: The stages, as `studies.papers.table.stages` returns them.
        jobs: The number of processes; with 1 the stages are computed in this process, in their order.
    """
    if jobs == 1:
        for name, stage in plan:
            yield name, stage()
        return
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        names = {pool.submit(stage): name for name, stage in plan}
        for done in as_completed(names):
            yield names[done], done.result()


def under_way(plan: Sequence[Stage], finished: Sequence[str], jobs: int) -> list[str]:
    """Return the names of the stages that are being computed while those named in `finished` are done."""
    return [name for name, _ in plan if name not in finished][:jobs]
