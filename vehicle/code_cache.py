"""Disk cache of compiled code, keyed by content.

There is one folder per content and signature, so that no stale code is read, concurrent processes write the
same, and another checkout or a new installation finds its code compiled. Without write access there is no
disk cache. The folders are in the user's cache or in NUMBA_CACHE_DIR.

numba's own `cache=True` is not enough: it compares the date of one source file, and so runs stale code when
a function that is called from another file has changed (numba's documentation, "Cache limitations"), and
compiles a file again that was only moved. Here numba's cache does the reading and writing; what is added is
the folder, which is chosen before a dispatcher compiles a signature. `Dispatcher.compile` and
`numba.core.caching` are no documented interface: `tests/vehicle/test_compiled.py` runs on the numba of
`.ci/constraints.txt`, and in `make smoke` on the oldest one that is allowed.
"""

from __future__ import annotations

import hashlib
import os
import sys
import tempfile
import threading
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numba
from numba.core.caching import CompileResultCacheImpl, FunctionCache

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
            versions = f"{numba.__version__} {sys.implementation.cache_tag}"
            folder = _folder_of(f"{digest_of(function)} {versions} {signature}")
            if folder is not None and Path(function.__code__.co_filename).is_file():
                dispatcher._cache = _Cache(dispatcher.py_func, folder)  # noqa: SLF001  as `enable_caching`
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


@dataclass(frozen=True, slots=True)
class _Place:
    """What numba asks a cache locator: where the code is, and from when; the folder's name is its content."""

    folder: Path
    _py_file: str  # named in numba's warning about code that cannot be kept

    def get_cache_path(self) -> str:
        return str(self.folder)

    def get_source_stamp(self) -> str:
        return ""

    def ensure_cache_path(self) -> None:
        """`_folder_of` has made the folder."""


class _Files(CompileResultCacheImpl):
    def __init__(self, function: FunctionType, folder: Path) -> None:
        self._locator = _Place(folder, function.__code__.co_filename)
        self._lineno = function.__code__.co_firstlineno
        self._filename_base = "code"


class _Cache(FunctionCache):
    """numba's cache of a function, in a folder that is given."""

    def __init__(self, function: FunctionType, folder: Path) -> None:
        self._impl_class: Any = partial(_Files, folder=folder)
        super().__init__(function)  # type: ignore[no-untyped-call]
