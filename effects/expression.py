"""Arithmetic formulas as text: parsed once, evaluated for arrays.

    sum     = product { ("+" | "-") product }
    product = signed { ("*" | "/") signed }
    signed  = "-" signed | power
    power   = atom [ "^" signed ]
    atom    = number | variable | function "(" sum { "," sum } ")" | "(" sum ")"

A formula can contain arithmetic only. Parsing gives the steps of a stack machine (reverse Polish notation),
whose evaluation needs no recursion.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from omnimate.effects.errors import ExpressionError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from omnimate.vehicle.se2 import Array

MAX_DEPTH = 50  # nesting of brackets, signs and powers, well below Python's recursion limit of 1000
EXPECTED_ATOM = "a number, a variable, a function or '('"
TOKEN = re.compile(
    r"(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|(?P<name>[A-Za-z_]\w*)|(?P<sign>[-+*/^(),])", re.ASCII
)


class Function(NamedTuple):
    """A function of the stack machine with its number of arguments."""

    apply: Callable[..., Any]
    arguments: int


FUNCTIONS = {
    **{name: Function(getattr(np, name), 1) for name in ("sin", "cos", "tan", "abs", "sign", "sqrt")},
    **{name: Function(getattr(np, name), 1) for name in ("exp", "log", "tanh")},
    "min": Function(np.minimum, 2),
    "max": Function(np.maximum, 2),
}
OPERATORS = {
    "+": Function(np.add, 2),
    "-": Function(np.subtract, 2),
    "*": Function(np.multiply, 2),
    "/": Function(np.divide, 2),
    "^": Function(np.power, 2),
}
NEGATIVE = Function(np.negative, 1)


@dataclass(frozen=True, slots=True)
class Expression:
    """A parsed formula."""

    steps: tuple[float | str | Function, ...]  # push a number or a variable, or apply a function

    @property
    def variables(self) -> frozenset[str]:
        """Names of the variables on which the formula depends."""
        return frozenset(step for step in self.steps if isinstance(step, str))

    def value(self, variables: Mapping[str, Array]) -> Array:
        """Return the value of the formula; not finite where it has none, such as 1 / 0.

        All variables have the same shape, which is that of the answer, or that of a number where the formula
        has no variables.
        """
        stack: list[Any] = []
        with np.errstate(all="ignore"):
            for step in self.steps:
                if isinstance(step, Function):
                    arguments = stack[-step.arguments :]
                    del stack[-step.arguments :]
                    stack.append(step.apply(*arguments))
                else:
                    stack.append(variables[step] if isinstance(step, str) else np.float64(step))
        return np.asarray(stack[0])


@lru_cache(maxsize=256)
def parse(text: str) -> Expression:
    """Return the parsed formula of a text.

    Raises:
        ExpressionError: The text is no formula; the error names the column and what was expected there.
    """
    reader = _Reader(text)
    reader.sum()
    if reader.kind:
        raise reader.error("an operator or the end")
    return Expression(tuple(reader.steps))


class _Reader:
    """A recursive-descent parser; every method parses the rule of its name."""

    def __init__(self, text: str) -> None:
        self.text, self.steps = text, list[float | str | Function]()
        self.kind, self.word, self.column, self._end, self._depth = "", "", 0, 0, 0
        self.advance()

    def error(self, expected: str) -> ExpressionError:
        """Return the error that something else was expected here."""
        return ExpressionError(self.text, self.column + 1, f"{self.word or 'the end'!r}; expected {expected}")

    def advance(self) -> None:
        """Advance to the next token; its kind is empty at the end."""
        while self._end < len(self.text) and self.text[self._end].isspace():
            self._end += 1
        self.column = self._end
        match = TOKEN.match(self.text, self.column)
        if match is None and self.column < len(self.text):
            self.word = self.text[self.column]
            raise self.error(f"{EXPECTED_ATOM}, or one of + - * / ^ , )")
        self.kind = (match and match.lastgroup) or ""
        self.word = match[0] if match else ""
        self._end = self.column + len(self.word)

    def accept_sign(self, *signs: str) -> str:
        """Return the current sign and advance if it is one of `signs`; otherwise return an empty text."""
        word = self.word if self.kind == "sign" and self.word in signs else ""
        if word:
            self.advance()
        return word

    def sum(self) -> None:
        self.product()
        while sign := self.accept_sign("+", "-"):
            self.product()
            self.steps.append(OPERATORS[sign])

    def product(self) -> None:
        self.signed()
        while sign := self.accept_sign("*", "/"):
            self.signed()
            self.steps.append(OPERATORS[sign])

    def signed(self) -> None:
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise self.error(f"at most {MAX_DEPTH} brackets, signs and powers in each other")
        if self.accept_sign("-"):
            self.signed()
            self.steps.append(NEGATIVE)
        else:
            self.power()
        self._depth -= 1

    def power(self) -> None:
        self.atom()
        if self.accept_sign("^"):
            self.signed()
            self.steps.append(OPERATORS["^"])

    def atom(self) -> None:
        word, kind = self.word, self.kind
        if kind == "number":
            if not math.isfinite(float(word)):
                raise self.error("a number below 1.8e308")
            self.advance()
            self.steps.append(float(word))
        elif kind == "name" and word in FUNCTIONS:
            self.advance()
            self.arguments(FUNCTIONS[word].arguments)
            self.steps.append(FUNCTIONS[word])
        elif kind == "name":
            self.advance()
            self.steps.append(word)
        elif word == "(":
            self.arguments(1)
        else:
            raise self.error(EXPECTED_ATOM)

    def arguments(self, count: int) -> None:
        """Parse `count` sums in brackets, separated by commas."""
        for expected in ("(", *[","] * (count - 1)):
            if not self.accept_sign(expected):
                raise self.error(f"{expected!r}")
            self.sum()
        if not self.accept_sign(")"):
            raise self.error("an operator or ')'")
