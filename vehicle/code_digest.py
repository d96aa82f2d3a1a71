"""Digest of everything that the compiled code of a function depends on.

Two functions with the same digest compile to the same machine code: it covers the function's own code, its
module, the constants that it names, and the same of every function that it calls, directly or not.
"""

from __future__ import annotations

import dis
import hashlib
from functools import cache
from types import CodeType, FunctionType, ModuleType
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator

_CONSTANTS = (bool, int, float, complex, str, bytes, tuple, np.ndarray, np.generic, np.dtype)


@cache
def digest_of(function: FunctionType) -> str:
    """Return a digest of a function and of all functions that it calls, directly or not."""
    digest = hashlib.sha256()
    reached = [function]
    for caller in reached:  # the list grows while it is read
        digest.update(_content(caller).encode())
        callees = map(function_behind, references_of(caller).values())
        reached += [callee for callee in callees if callee is not None and callee not in reached]
    return digest.hexdigest()


def references_of(function: FunctionType) -> dict[str, object]:
    """Return what a function's code refers to by name: globals, and variables of the functions around it."""
    cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    scope = {**function.__globals__, **{name: cell.cell_contents for name, cell in cells}}
    return {name: scope[name] for name in sorted(set(_names(function.__code__))) if name in scope}


def function_behind(value: object) -> FunctionType | None:
    """Return a plain function, or the one that a wrapper keeps as `__wrapped__`; None for anything else."""
    inside = getattr(value, "__wrapped__", value)
    return inside if isinstance(inside, FunctionType) else None


def _content(function: FunctionType) -> str:
    """Return a function's code and its constants, without the functions that it calls."""
    code, references = function.__code__, references_of(function)
    constants = {name: _constant(value) for name, value in references.items()}
    for name, value in references.items():
        if isinstance(value, ModuleType):
            inside = {f"{name}.{inner}": getattr(value, inner, None) for inner in code.co_names}
            constants |= {path: _constant(inner) for path, inner in inside.items()}
    place = function.__module__, function.__qualname__  # numba's cache imports the module by its name
    return repr((*place, _code(code), function.__defaults__, sorted(constants.items())))


def _code(code: CodeType) -> tuple[object, ...]:
    constants = [_code(value) if isinstance(value, CodeType) else repr(value) for value in code.co_consts]
    return code.co_code, code.co_names, code.co_varnames, code.co_freevars, code.co_argcount, constants


def _constant(value: object) -> str:
    """Return a constant as text; nothing for what is none, such as a function or a module."""
    if isinstance(value, np.ndarray):
        return repr((value.dtype, value.shape, value.tobytes()))
    return repr(value) if isinstance(value, _CONSTANTS) else ""


def _names(code: CodeType) -> Iterator[str]:
    """Yield the globals and the outer variables that code refers to, also inside of comprehensions."""
    yield from code.co_freevars
    for instruction in dis.get_instructions(code):
        if instruction.opname in {"LOAD_GLOBAL", "LOAD_NAME"}:
            yield str(instruction.argval)
    for value in code.co_consts:
        if isinstance(value, CodeType):
            yield from _names(value)
