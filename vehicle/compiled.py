"""Compiled functions and their records.

Code that runs for every sample, live and in simulations, is compiled by numba, so that both use the same
code. A compiled function reads and writes records: the fields of a small class whose annotations are
`int`, `float`, or `Annotated[Array, shape]`, laid out as one numpy record by `layout`.
"""

from __future__ import annotations

import functools
import threading
from types import CellType, FunctionType
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, cast, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from omnimate.vehicle.code_digest import function_behind, references_of

if TYPE_CHECKING:
    from collections.abc import Callable

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
Record = NDArray[np.void]

Function = TypeVar("Function", bound="Callable[..., object]")

_PREPARING = threading.RLock()


def compiled(function: Function) -> Function:
    """Return a function that is compiled when it is called for the first time.

    numba is imported at that moment only. The machine code is kept on disk for the next process, see
    `code_cache`. Functions that it calls are compiled with it, whether they are marked or not.
    """
    return cast("Function", _compiled(cast("FunctionType", function)))


def compiled_without_lock(function: Function) -> Function:
    """Return a compiled function during which other Python threads go on; see `compiled`.

    Its arrays must be those of one thread alone.
    """
    made = Compiled(cast("FunctionType", function), is_locked=False)
    return cast("Function", made)


class Compiled:
    """A plain function, `__wrapped__`, and its compiled form, made at the first call."""

    def __init__(self, function: FunctionType, *, is_locked: bool = True) -> None:
        functools.update_wrapper(self, function)
        self.__wrapped__ = function
        self._is_locked = is_locked  # whether Python's interpreter stays locked while it runs
        self._call: Callable[..., Any] = self._compile_and_call
        self._dispatcher: Any = None

    def __call__(self, *args: object) -> Any:  # noqa: ANN401  # what the function returns
        """Call the compiled function."""
        return self._call(*args)

    def native(self) -> Any:  # noqa: ANN401  # numba has no types
        """Return numba's dispatcher, which other compiled functions call without going through Python."""
        with _PREPARING:
            if self._dispatcher is None:
                self._prepare()
            return self._dispatcher

    def _compile_and_call(self, *args: object) -> object:
        self._call = self.native()
        return self._call(*args)

    def _prepare(self) -> None:
        """Make the dispatcher of a copy of the function whose globals name dispatchers for functions."""
        import numba

        from omnimate.vehicle.code_cache import keep_by_content

        function = self.__wrapped__
        scope = dict(function.__globals__)
        closure = tuple(CellType(_native(cell.cell_contents)) for cell in function.__closure__ or ())
        copy = FunctionType(function.__code__, scope, function.__name__, function.__defaults__, closure)
        copy.__qualname__ = function.__qualname__
        self._dispatcher = numba.njit(error_model="numpy", nogil=not self._is_locked)(
            copy
        )  # before those that it calls, itself perhaps
        keep_by_content(self._dispatcher, function)
        scope.update({name: _native(value) for name, value in references_of(function).items()})


@functools.cache
def _compiled(function: FunctionType) -> Compiled:
    return Compiled(function)


def _native(value: object) -> object:
    """Return what compiled code uses in place of a global: for a function, its dispatcher."""
    function = function_behind(value)
    return value if function is None else _compiled(function).native()


@functools.cache
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
