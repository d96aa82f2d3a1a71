"""Descriptions of a request's wrong values, in the terms of this service instead of pydantic's."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

SHOWN_ERRORS = 20
MAX_SHOWN_LENGTH = 60  # characters of a value that is shown again

_NUMBER = "a number"
_WHOLE = "a whole number"
_TEXT = "text"
_EXPECTED = {  # by pydantic's type of the error, with what its context holds
    "literal_error": "{expected}",
    "greater_than": "more than {gt}",
    "greater_than_equal": "{ge} or more",
    "less_than": "less than {lt}",
    "less_than_equal": "{le} or less",
    "finite_number": "a finite number",
    "float_parsing": _NUMBER,
    "float_type": _NUMBER,
    "int_parsing": _WHOLE,
    "int_type": _WHOLE,
    "int_from_float": _WHOLE,
    "int_parsing_size": _WHOLE,
    "bool_parsing": "true or false",
    "bool_type": "true or false",
    "string_type": _TEXT,
    "string_too_short": "{min_length} characters or more",
    "string_too_long": "{max_length} characters at most",
    "string_pattern_mismatch": "text of the form {pattern}",
    "list_type": "a list",
    "too_short": "{min_length} or more of them",
    "too_long": "{max_length} of them at most",
    "model_attributes_type": "a JSON object",
    "model_type": "a JSON object",
    "dict_type": "a JSON object",
    "date_from_datetime_parsing": "a date as YYYY-MM-DD",
    "date_parsing": "a date as YYYY-MM-DD",
}


def wrong_values(errors: Sequence[Mapping[str, Any]]) -> list[dict[str, str]]:
    """Return the field and the problem of each of pydantic's errors."""
    return [{"where": _where(error["loc"]), "problem": _problem(error)} for error in errors[:SHOWN_ERRORS]]


def _where(location: Sequence[str | int]) -> str:
    """Return a field's name; pydantic adds the names of its classes where there are several forms."""
    return ".".join(str(part) for part in location if not (isinstance(part, str) and part[:1].isupper()))


def _problem(error: Mapping[str, Any]) -> str:
    kind, context = error["type"], error.get("ctx", {})
    if kind == "missing":
        return "missing"
    if kind == "extra_forbidden":
        return "unknown; leave it out, or see /openapi.json for the fields that there are"
    if kind == "json_invalid":
        return f"no JSON: {context['error']}"
    if kind == "value_error":  # of a validator of this service
        return str(context["error"])
    given = repr(error["input"])
    shown = given if len(given) <= MAX_SHOWN_LENGTH else f"{given[:MAX_SHOWN_LENGTH]}..."
    limits = {name: f"{value:g}" if isinstance(value, float) else value for name, value in context.items()}
    expected = _EXPECTED.get(kind, f"another value ({kind})").format(**limits)
    return f"{shown}; expected {expected}"
