"""How the service's processes begin: with their libraries loaded, where the system can do that."""

from __future__ import annotations

import multiprocessing
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from multiprocessing.context import ForkServerContext, SpawnContext

PRELOADED = ["omnimate.service.robot.robot_server", "omnimate.service.jobs.diagnosing", "omnimate.mismatch"]


def process_context() -> ForkServerContext | SpawnContext:
    """Return the context in which all processes of the service are made.

    On Linux they are forked from one process of a single thread that has loaded the libraries, so that the
    robot and each upload or diagnosis begin at once. Elsewhere, where a fork is not safe, each loads them.
    """
    if sys.platform != "linux":
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(PRELOADED)
    return context


def begin_loading() -> None:
    """Start the process that loads the libraries, while this one loads its own."""
    if sys.platform == "linux":
        process_context()
        from multiprocessing.forkserver import ensure_running

        ensure_running()
