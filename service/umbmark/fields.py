"""Constrained types of the REST interface: every number is finite, has bounds, and is in SI units."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

How = Literal["manual", "recordings", "drive"]
Direction = Literal["cw", "ccw"]
Method = Literal["printed-x", "printed-y", "printed", "printed-true-b", "heading", "exact", "weighted"]
Severity = Literal["note", "warning", "error"]
State = Literal[
    "collecting", "driving", "measuring", "interrupted", "solved", "accepted", "aborted", "failed", "expired"
]
Call = Literal["sample", "remove", "solve", "accept", "resume", "abort"]

Metre = Annotated[float, Field(ge=-1000.0, le=1000.0, allow_inf_nan=False, description="[m]")]
Range = Annotated[float, Field(gt=0.0, le=100.0, allow_inf_nan=False, description="[m]")]
Radian = Annotated[
    float,
    Field(ge=-2.0 * math.pi, le=2.0 * math.pi, allow_inf_nan=False, description="[rad], counter-clockwise"),
]
NAME_PATTERN = r"^[^\x00-\x1f/\\]{1,100}$"
Name = Annotated[str, Field(min_length=1, max_length=100, pattern=NAME_PATTERN)]
Id = Annotated[str, Field(min_length=1, max_length=32, pattern=r"^[0-9a-z]+$")]


class RequestModel(BaseModel):
    """The body of a request; a field that is not known is refused."""

    model_config = ConfigDict(extra="forbid", str_strip_whitespace=True)
