"""Disk cache of compiled code, keyed by content.

There is one folder per content and signature, so that no stale code is read, and concurrent processes write
the same. Without write access there is no disk cache. The folders are in the user's cache or in
NUMBA_CACHE_DIR.

numba's own `cache=True` is not enough: it compares the date of one source file, and so runs stale code when
a function that is called from another file has changed (numba's documentation, "Cache limitations"). Here
numba's documented cache does the reading and writing; what is added is the folder, which is chosen before a
dispatcher compiles a signature. `Dispatcher.compile` and `enable_caching` are no documented interface:
`tests/vehicle/test_compiled.py` runs on the numba of `.ci/constraints.txt`, and in `make smoke` on the oldest
one that is allowed.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
import threading
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numba

from omnimate.vehicle.code_digest import digest_of

if TYPE_CHECKING:
    from types import FunctionType

COMPILING = threading.RLock()  # held while a function is prepared or compiled
_CONFIG: Any = numba.config


def keep_by_content(dispatcher: Any, function: FunctionType) -> None:  # noqa: ANN401  # numba has no types
    """Make numba's dispatcher of a function look up compiled code on disk before compiling a signature."""
    compile_signature = dispatcher.compile

    def compile_or_load(signature: object) -> object:
        with COMPILING:
            folder = _folder_of(f"{digest_of(function)} {numba.__version__} {signature}")
            if folder is not None and Path(function.__code__.co_filename).is_file():
                _keep_in(folder, dispatcher)
            return compile_signature(signature)

    dispatcher.compile = compile_or_load


def _folder_of(content: str) -> Path | None:
    """Return the folder for a content; None where it cannot be written."""
    name = hashlib.sha256(content.encode()).hexdigest()
    try:
        folder = _base() / name[:2] / name[2:]
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except (OSError, RuntimeError):  # not writable, or a user without a home
        return None


def _base() -> Path:
    if _CONFIG.CACHE_DIR:
        return Path(_CONFIG.CACHE_DIR)
    caches = os.environ.get("XDG_CACHE_HOME") or Path("~", ".cache").expanduser()
    return Path(caches) / "omnimate" / "compiled"


def _keep_in(folder: Path, dispatcher: Any) -> None:  # noqa: ANN401
    configured = _CONFIG.CACHE_DIR
    _CONFIG.CACHE_DIR = str(folder)
    try:
        dispatcher.enable_caching()
    finally:
        _CONFIG.CACHE_DIR = configured
