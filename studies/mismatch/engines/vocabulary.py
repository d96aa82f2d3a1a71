"""The vocabulary: effects that may be concealed, their components and sizes, and their labels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    Array = NDArray[np.float64]

WHEELS = ("a.left", "a.right", "b.left", "b.right")
JOINTS = ("joint_a", "joint_b")
LINKAGE = (*JOINTS, "link")
TRUCKS = ("a", "b")

# Bounds of each effect's size, as robots in use show them, far enough above the noise.
SIZES: dict[str, dict[str, tuple[float, float]]] = {
    "wheel_diameter": {"ratio": (0.002, 0.006)},
    "wheel_eccentricity": {"amplitude": (2e-4, 8e-4)},
    "radius_vs_speed": {"slope": (0.008, 0.02)},
    "radius_step": {"ratio": (0.003, 0.008)},
    "bump": {"lost": (1.5e-3, 4e-3)},
    "slip_patch": {"fraction": (0.03, 0.1)},
    "traction_slip": {"compliance": (0.05, 0.15)},
    "wheelbase": {"ratio": (0.006, 0.02)},
    "turn_scrub": {"slope": (0.005, 0.015)},
    "wheel_misalignment": {"angle": (0.004, 0.012)},
    "lateral_slip": {"compliance": (0.02, 0.08)},
    "floor_slope": {"rate": (0.004, 0.012)},
    "castor_kick": {"yaw": (0.01, 0.03)},
    "joint_bias": {"bias": (0.004, 0.012)},
    "joint_eccentricity": {"amplitude": (0.004, 0.012)},
    "joint_backlash": {"width": (0.01, 0.03)},
    "link_bias": {"bias": (0.004, 0.012)},
    "link_eccentricity": {"amplitude": (0.003, 0.008)},
    "link_scale": {"ratio": (0.05, 0.15)},
    "count_loss": {"fraction": (0.004, 0.012)},
    "latency": {"delay": (0.03, 0.08)},
    "gear_backlash": {"width": (0.002, 0.006)},
    "gear_harmonic": {"amplitude": (2e-4, 5e-4)},
    "clock_drift": {"rate": (3e-4, 8e-4)},
}
RATIOS = {"wheel_diameter", "radius_step", "wheelbase", "link_scale"}
SIGNED = {"radius_vs_speed", "wheel_misalignment", "castor_kick", "joint_bias", "link_bias"}
UNITS = {
    "ratio": "1", "amplitude": "m", "phase": "rad", "slope": "1", "time": "s", "times": "s", "lost": "m",
    "fraction": "1", "compliance": "s", "angle": "rad", "rate": "1", "direction": "rad", "yaw": "rad",
    "bias": "rad", "width": "rad", "above": "m/s", "delay": "s", "order": "1",
}  # fmt: skip
OF_WHEELS = {
    "wheel_diameter", "wheel_eccentricity", "radius_vs_speed", "radius_step", "bump", "slip_patch",
    "traction_slip",
    "count_loss", "gear_backlash", "gear_harmonic",
}  # fmt: skip
OF_TRUCKS = {"wheelbase", "turn_scrub", "wheel_misalignment", "lateral_slip", "floor_slope", "castor_kick"}
OF_JOINTS = {"joint_bias", "joint_eccentricity", "joint_backlash"}
# Physics without a name among the effects, and the components that it is put into.
UNNAMED: dict[str, tuple[str, ...]] = {
    "slabs": ("left", "right"),
    "warming": ("a.left", "b.right"),
    "hum": ("a.right", "b.left"),
    "pushes": ("a", "b"),
    "magnet": ("b",),
    "tiring": ("a",),
    "crosstalk": ("joint_a", "joint_b"),
    "sag": ("link",),
}
# Effects that a drive may not separate, by judgement: a right answer names the effect or one of these.
ALIKE: dict[str, tuple[str, ...]] = {
    "wheel_diameter": ("radius_vs_speed", "count_loss", "radius_step"),
    "radius_vs_speed": ("wheel_diameter", "count_loss"),
    "count_loss": ("wheel_diameter", "radius_vs_speed"),
    "radius_step": ("slip_patch", "wheel_diameter"),
    "slip_patch": ("radius_step", "bump"),
    "bump": ("slip_patch",),
    "wheelbase": ("turn_scrub",),
    "turn_scrub": ("wheelbase",),
    "traction_slip": ("latency",),
    "castor_kick": ("gear_backlash",),
    "gear_backlash": ("castor_kick",),
    "joint_bias": ("wheel_misalignment", "joint_eccentricity"),
    "wheel_misalignment": ("joint_bias", "joint_eccentricity"),
    "joint_eccentricity": ("joint_bias", "wheel_misalignment"),
    "link_bias": ("link_eccentricity", "link_scale"),
    "link_eccentricity": ("link_bias", "link_scale"),
    "link_scale": ("link_bias", "link_eccentricity"),
    "latency": ("traction_slip", "clock_drift", "joint_backlash"),
    "clock_drift": ("latency",),
    "joint_backlash": ("latency",),
    "lateral_slip": ("wheel_misalignment",),
    "floor_slope": (),
    "wheel_eccentricity": ("gear_harmonic",),
    "gear_harmonic": (),
}


def components(effect: str) -> tuple[str, ...]:
    """Return the components on which an effect acts."""
    if effect in OF_WHEELS:
        return WHEELS
    if effect in OF_TRUCKS:
        return TRUCKS
    if effect in OF_JOINTS:
        return JOINTS
    return JOINTS if effect in {"latency", "clock_drift"} else ("link",)


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
