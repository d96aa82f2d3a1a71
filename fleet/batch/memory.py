"""Memory that a recording's work has needed, given back to the system before the next one.

What triage and diagnosis know of a recording refers to itself in circles, which Python's collector leaves for
long where as many objects live as compiled code needs. And glibc keeps for the process what is freed between
small pieces that are not (Dask, "Worker Memory Management", on memory that is not released back to the
system; the remedy is theirs). Without it a process grew by 14 MB with each lap of a robot with a linkage.
"""

from __future__ import annotations

import ctypes
import gc
import sys


def give_back() -> None:
    """Collect what nothing refers to, and give free memory back to the system where glibc can."""
    gc.collect()
    if sys.platform == "linux":
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # other C libraries have none
        if trim is not None:
            trim(0)
