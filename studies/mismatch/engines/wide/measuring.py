"""Measurements of all kinds: none, sparse, dense; as good as stated, or worse; off the centre, or late."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from studies.mismatch.engines.wide.robots import within
from studies.mismatch.engines.writing import Measuring

if TYPE_CHECKING:
    from numpy.random import Generator

PLACES, HEADINGS = (5e-4, 0.01), (5e-4, 0.01)  # [m], [rad] that are stated
PERIODS = (0.02, 0.05, 0.1, 0.2, 1.0)  # [s]
WRONG = 3.0  # factor by which what is stated may be wrong, both ways
LEVER = 0.01  # [m] by which markers sit off the centre, at most
LATE = (0.01, 0.1)  # [s]


def wide_measuring(chance: Generator, trucks: int, *, dense: bool = False) -> Measuring | None:
    """Return how a drive's poses are measured; a robot with one truck is measured somehow.

    Args:
        chance: Source of what is drawn.
        trucks: Number of trucks.
        dense: Whether poses must be dense.
    """
    kind = (
        chance.choice(["none", "stops", "dense", "dense"])
        if trucks == 2
        else chance.choice(["stops", "dense"])
    )
    if kind == "none" and not dense:
        return None
    place, heading = within(chance, PLACES), within(chance, HEADINGS)
    honest, centred, prompt = chance.random(3) < (0.5, 0.75, 0.8)
    angle = float(chance.uniform(-math.pi, math.pi))
    off = 0.0 if centred else float(chance.uniform(0.002, LEVER))
    return Measuring(
        sigma=(place, place, heading),
        period=float(chance.choice(PERIODS)) if dense or kind == "dense" else 0.0,
        both=trucks == 2 and bool(chance.random() < 0.5),
        noise=1.0 if honest else within(chance, (1.0 / WRONG, WRONG)),
        lever=(off * math.cos(angle), off * math.sin(angle)),
        delay=0.0 if prompt or kind == "stops" else within(chance, LATE),
        outliers=0.0 if chance.random() < 0.8 else 0.01,
    )


def secondary(measuring: Measuring | None) -> list[dict[str, str]]:
    """Return what is true of the poses beside any fault: naming it is right, missing it no mistake."""
    if measuring is None:
        return []
    true = []
    if measuring.delay:
        true += ["latency", "clock_drift", "unknown"]
    if measuring.lever != (0.0, 0.0) or measuring.outliers or measuring.noise > 1.0:
        true += ["unknown"]
    return [{"effect": effect, "component": "poses"} for effect in dict.fromkeys(true)]
