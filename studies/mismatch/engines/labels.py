"""The labels of what the engine conceals."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from studies.mismatch.engines.vocabulary import ALIKE, OF_JOINTS, OF_TRUCKS, UNITS, components

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    Array = NDArray[np.float64]


def label(effect: str, component: str, parameters: dict[str, Any]) -> dict[str, Any]:
    """Return the label of one effect."""
    intervals = parameters.get("intervals", [])
    if effect == "bump":
        intervals = [[time, time + 0.3] for time in parameters["times"]]
    shown = {
        name: {"value": value, "unit": UNITS.get(name, "")}
        for name, value in parameters.items()
        if name != "intervals" and effect != "unknown"
    }
    alike = [
        {"effect": other, "component": place, "by_judgement": True}
        for other, place in _alike(effect, component)
    ]
    return {
        "effect": effect,
        "component": component,
        "parameters": shown,
        "intervals": intervals,
        "acceptable": alike,
    }


def set_bump_times(label: dict[str, Any], time: Array, counts: NDArray[np.int64]) -> None:
    """Set the times of a bump's label to when the wheel meets them: while it stands it meets none.

    Args:
        label: Label of the bumps, which is changed.
        time: Time of each sample [s], shape `(N,)`.
        counts: Raw counts of the wheel, shape `(N,)`.
    """
    rolls = np.diff(counts) != 0
    begins, ends = time[:-1][rolls], time[1:][rolls]
    known = label["parameters"]["times"]
    at = np.searchsorted(ends, known["value"], side="right").clip(max=len(ends) - 1)
    known["value"] = np.maximum(known["value"], begins[at]).tolist()
    label["intervals"] = [[start, start + 0.3] for start in known["value"]]


def _alike(effect: str, component: str) -> Iterator[tuple[str, str]]:
    for other in ALIKE.get(effect, ()):
        if component in components(other):
            yield other, component
        elif other in OF_JOINTS and component in {"a", "b"}:
            yield other, f"joint_{component}"
        elif other in OF_TRUCKS:
            yield other, component.removeprefix("joint_")[:1]
        elif other == "gear_backlash":
            yield from ((other, f"{component}.left"), (other, f"{component}.right"))
