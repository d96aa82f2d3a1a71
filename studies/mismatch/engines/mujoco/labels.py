"""Labels of a MuJoCo drive."""

from __future__ import annotations

from typing import Any

UNITS = {
    "ratio": "1", "amplitude": "m", "phase": "rad", "angle": "rad", "bias": "m", "lost": "m", "times": "s",
    "time": "s", "compliance": "s", "rate": "1", "direction": "rad", "fraction": "1", "yaw": "rad",
}  # fmt: skip


def label(
    effect: str,
    component: str,
    values: dict[str, Any],
    acceptable: tuple[tuple[str, str], ...] = (),
    intervals: list[list[float]] | None = None,
) -> dict[str, Any]:
    """Return the label of an effect as `labels.json` holds it; amplitudes and biases of joints are angles."""
    units = UNITS | ({"amplitude": "rad", "bias": "rad"} if component.startswith("joint") else {})
    return {
        "effect": effect,
        "component": component,
        "parameters": {name: {"value": value, "unit": units[name]} for name, value in values.items()},
        "intervals": intervals or [],
        "acceptable": [
            {"effect": name, "component": where, "by_judgement": True} for name, where in acceptable
        ],
    }
