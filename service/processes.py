"""How the service's processes begin: with their libraries loaded, where the system can do that."""

from __future__ import annotations

import multiprocessing
import sys
from contextlib import suppress
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from multiprocessing.context import ForkServerContext, SpawnContext

PRELOADED = ["omnimate.service.robot.robot_server", "omnimate.service.jobs.diagnosing", "omnimate.mismatch"]


def process_context() -> ForkServerContext | SpawnContext:
    """Return the context in which all processes of the service are made.

    On Linux they are forked from one process of a single thread that loads the libraries from the first call
    on, so that the robot and each upload or diagnosis begin at once. Elsewhere, where a fork is not safe, and
    without a temporary folder for its socket, each loads them.
    """
    if sys.platform == "linux":
        from multiprocessing.forkserver import ensure_running

        context = multiprocessing.get_context("forkserver")
        context.set_forkserver_preload(PRELOADED)
        with suppress(OSError):
            ensure_running()
            return context
    return multiprocessing.get_context("spawn")
