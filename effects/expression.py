"""Formulas as text: read by a parser of their own, and evaluated for many steps at once.

    sum     = product { ("+" | "-") product }
    product = signed { ("*" | "/") signed }
    signed  = "-" signed | power
    power   = atom [ "^" signed ]
    atom    = number | variable | function "(" sum { "," sum } ")" | "(" sum ")"

A formula can do nothing but arithmetic. Reading it turns it into steps for a stack (reverse Polish notation),
so that its evaluation needs no recursion.
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

DEPTH = 50  # of brackets, signs and powers; Python's own limit of 1000 calls is far away
ATOM = "a number, a variable, a function or '('"
TOKEN = re.compile(
    r"(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|(?P<name>[A-Za-z_]\w*)|(?P<sign>[-+*/^(),])", re.ASCII
)


class Function(NamedTuple):
    """What takes some numbers from the stack and leaves one."""

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
    """A formula that was read.

    Attributes:
        steps: What is done with the stack: a number, or the value of a variable, is put on it, or a function
            is applied.
    """

    steps: tuple[float | str | Function, ...]

    @property
    def variables(self) -> frozenset[str]:
        """Names of the variables on which the formula depends."""
        return frozenset(step for step in self.steps if isinstance(step, str))

    def value(self, variables: Mapping[str, Array]) -> Array:
        """Return the value of the formula; not finite where it has none, such as 1 / 0.

        Args:
            variables: Value of each variable; all have the same shape, which is that of the answer, or that
                of a number where the formula has no variables.
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
    """Return the expression that a text stands for.

    Raises:
        ExpressionError: The text is no formula; the error names the column and what was expected there.
    """
    reader = _Reader(text)
    reader.sum()
    if reader.kind:
        raise reader.error("an operator or the end")
    return Expression(tuple(reader.steps))


class _Reader:
    """A text that is read from left to right; every method reads the rule of its name."""

    def __init__(self, text: str) -> None:
        self.text, self.steps = text, list[float | str | Function]()
        self.kind, self.word, self.column, self._end, self._depth = "", "", 0, 0, 0
        self.go_on()

    def error(self, expected: str) -> ExpressionError:
        """Return the error that something else was expected here."""
        return ExpressionError(self.text, self.column + 1, f"{self.word or 'the end'!r}; expected {expected}")

    def go_on(self) -> None:
        """Go to the next token; at the end its kind is empty."""
        while self._end < len(self.text) and self.text[self._end].isspace():
            self._end += 1
        self.column = self._end
        match = TOKEN.match(self.text, self.column)
        if match is None and self.column < len(self.text):
            self.word = self.text[self.column]
            raise self.error(f"{ATOM}, or one of + - * / ^ , )")
        self.kind = (match and match.lastgroup) or ""
        self.word = match[0] if match else ""
        self._end = self.column + len(self.word)

    def took(self, *signs: str) -> str:
        """Return the sign that stands here and go on; empty where it is none of these."""
        word = self.word if self.kind == "sign" and self.word in signs else ""
        if word:
            self.go_on()
        return word

    def sum(self) -> None:
        self.product()
        while sign := self.took("+", "-"):
            self.product()
            self.steps.append(OPERATORS[sign])

    def product(self) -> None:
        self.signed()
        while sign := self.took("*", "/"):
            self.signed()
            self.steps.append(OPERATORS[sign])

    def signed(self) -> None:
        self._depth += 1
        if self._depth > DEPTH:
            raise self.error(f"at most {DEPTH} brackets, signs and powers in each other")
        if self.took("-"):
            self.signed()
            self.steps.append(NEGATIVE)
        else:
            self.power()
        self._depth -= 1

    def power(self) -> None:
        self.atom()
        if self.took("^"):
            self.signed()
            self.steps.append(OPERATORS["^"])

    def atom(self) -> None:
        word, kind = self.word, self.kind
        if kind == "number":
            if not math.isfinite(float(word)):
                raise self.error("a number below 1.8e308")
            self.go_on()
            self.steps.append(float(word))
        elif kind == "name" and word in FUNCTIONS:
            self.go_on()
            self.arguments(FUNCTIONS[word].arguments)
            self.steps.append(FUNCTIONS[word])
        elif kind == "name":
            self.go_on()
            self.steps.append(word)
        elif word == "(":
            self.arguments(1)
        else:
            raise self.error(ATOM)

    def arguments(self, count: int) -> None:
        """Read so many sums in brackets, with commas between them."""
        for expected in ("(", *[","] * (count - 1)):
            if not self.took(expected):
                raise self.error(f"{expected!r}")
            self.sum()
        if not self.took(")"):
            raise self.error("an operator or ')'")
