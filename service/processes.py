"""How the service's processes begin: with their libraries loaded, and which freed memory they return."""

from __future__ import annotations

import ctypes
import multiprocessing
import sys
from contextlib import suppress
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from multiprocessing.context import ForkServerContext, SpawnContext

PRELOADED = ["omnimate.service.robot.robot_server", "omnimate.service.jobs.diagnosing", "omnimate.mismatch"]
M_TRIM_THRESHOLD = -1  # of glibc's malloc.h
TRIM_THRESHOLD = 128 * 1024  # [bytes], glibc's own at the start of a process (mallopt(3))


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


def return_freed_memory() -> None:
    """Have glibc return freed memory of this process to the system, whatever the size of former uploads.

    By default a freed block raises the thresholds from which blocks have pages of their own, and from which
    the end of an arena is returned, to its size and twice that (32 MB and 64 MB at most). Each of up to eight
    arenas for each core then keeps so much. Setting one of the thresholds ends that (mallopt(3)). Nothing is
    done with another C library.
    """
    if sys.platform == "linux":
        with suppress(AttributeError):
            ctypes.CDLL(None).mallopt(M_TRIM_THRESHOLD, TRIM_THRESHOLD)
