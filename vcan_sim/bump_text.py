"""Bumps as text: `wheel=a.right,after=3,height=0.01` is a cable of 10 mm under a wheel."""

from __future__ import annotations

from functools import partial
from typing import Any, cast

from omnimate.vcan_sim.bumps import Bump
from omnimate.vcan_sim.errors import BumpError, SimulationError
from omnimate.vcan_sim.key_values import INTEGER, NUMBER, TEXT, Kind, read_values

_KINDS: dict[str, Kind] = {
    "wheel": TEXT,
    "after": NUMBER,
    "lap": INTEGER,
    "x": NUMBER,
    "y": NUMBER,
    "size": NUMBER,
    "height": NUMBER,
    "shape": TEXT,
}


def parse_bump(text: str) -> Bump:
    """Return the bump that a text such as `wheel=a.right,after=3,height=0.01` describes.

    Raises:
        BumpError: A key is not known, or a value cannot be read or is out of its bounds.
    """
    if not text:
        raise BumpError(text, f"expected key=value with {', '.join(_KINDS)}")
    values = read_values(text, _KINDS, partial(BumpError, text))
    try:
        return Bump(**cast("dict[str, Any]", values))
    except SimulationError as error:
        raise BumpError(text, str(error)) from error
