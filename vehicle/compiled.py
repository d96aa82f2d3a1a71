"""Compiled functions, and the records that they work on.

What runs once per sample, live and in simulations, is compiled by numba, so that both run the same
code. A compiled function reads and writes records: the fields of a small class whose annotations are
`int`, `float`, or `Annotated[Array, shape]`, laid out as one numpy record by `layout`.
"""

from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeVar, cast, get_args, get_origin, get_type_hints

import numba
import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from collections.abc import Callable

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
Record = NDArray[np.void]

COMPILING_ROOMS = ("vehicle", "motion", "ipec", "calib", "vcan_sim", "mismatch")

Function = TypeVar("Function", bound="Callable[..., object]")


def compiled(function: Function) -> Function:
    """Compile a function at its first call, and keep the result on disk for the next process."""
    _forget_stale(Path(function.__code__.co_filename).parent)
    try:
        compile_ = numba.njit(cache=True, error_model="numpy")
        return cast("Function", compile_(function))
    except RuntimeError:  # nowhere to keep it: no writable folder at all
        return cast("Function", numba.njit(error_model="numpy")(function))


@lru_cache
def _forget_stale(room: Path) -> None:
    """Drop what was compiled in a room before any source of the rooms that compile changed.

    numba compares the date of a function's own file only, not of the files whose functions it calls.
    """
    rooms = {room, *(Path(__file__).parents[1] / name for name in COMPILING_ROOMS)}
    newest = max(source.stat().st_mtime for one in rooms for source in one.glob("*.py"))
    for index in (room / "__pycache__").glob("*.nbi"):
        with suppress(FileNotFoundError):  # another process may be at it, too
            if index.stat().st_mtime < newest:
                index.unlink(missing_ok=True)


def layout(fields: type) -> np.dtype[np.void]:
    """Return the numpy record type with the annotated fields of a class."""
    hints = get_type_hints(fields, include_extras=True)
    return np.dtype([(name, *_column(hint)) for name, hint in hints.items()])


def record(fields: type) -> Record:
    """Return one record `(1,)` of a class's fields, all zero."""
    return np.zeros(1, layout(fields))


def _column(hint: object) -> tuple[object, ...]:
    if get_origin(hint) is Annotated:
        array, shape = get_args(hint)
        return (np.int64 if array == IntArray else np.float64, shape)
    return (hint,)
