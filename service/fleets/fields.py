"""Constrained types of the calls about fleets."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, StringConstraints

# Names are folders of a store, and parts of URLs: nothing in them is special to either.
PLAIN_PATTERN = r"^[A-Za-z0-9][A-Za-z0-9._-]*$"
DAY_PATTERN = r"^[0-9]{4}-(0[1-9]|1[0-2])-(0[1-9]|[12][0-9]|3[01])$"
PlainName = Annotated[str, StringConstraints(min_length=1, max_length=64, pattern=PLAIN_PATTERN)]
Day = Annotated[str, Field(pattern=DAY_PATTERN, description="A date, YYYY-MM-DD.")]
State = Literal["fine", "drift", "sick", "unjudged"]
FindingState = Literal["open", "closed"]
DeliveryState = Literal["waiting", "accepted", "given up"]
