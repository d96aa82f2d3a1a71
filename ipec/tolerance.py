"""Errors of a heading against the resolution of its encoders."""

from omnimate.vehicle.compiled import compiled


@compiled
def beyond(error: float, tolerance: float) -> float:
    """Return the part of an error that lies outside of plus or minus a tolerance, in the same unit."""
    return error - min(max(error, -tolerance), tolerance)
