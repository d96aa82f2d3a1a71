"""Errors of the call itself, which no room below can see."""

from __future__ import annotations

from omnimate.vehicle.errors import OmnimateError


class CallError(OmnimateError):
    """A call whose options contradict each other, or from which something is missing."""
