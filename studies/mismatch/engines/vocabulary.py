"""The vocabulary: effects that may be concealed, their components and sizes, and their labels."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

WHEELS = ("a.left", "a.right", "b.left", "b.right")
JOINTS = ("joint_a", "joint_b")
LINKAGE = (*JOINTS, "link")
TRUCKS = ("a", "b")


class Effect(NamedTuple):
    """An effect of the vocabulary, by the parameter that is its size."""

    components: tuple[str, ...]  # components on which it acts
    parameter: str  # name of the parameter; a "ratio" is 1 without the effect, every other parameter 0
    unit: str  # unit of the parameter
    # bounds of the sizes that the own engine conceals: as robots in use show them, far enough above the noise
    concealed: tuple[float, float]
    usual: float  # A usual size, as step of numerical differences

    def sized(self, size: float, others: Mapping[str, Any]) -> dict[str, Any]:
        """Return all parameters of the effect in a size, with its sign, by name."""
        value: Any = 1.0 + size if self.parameter == "ratio" else size
        if self.parameter == "lost":
            value = [size] * len(others["times"])
        return {**others, self.parameter: value}


VOCABULARY = {
    "wheel_diameter": Effect(WHEELS, "ratio", "1", (0.002, 0.006), 0.003),
    "wheel_eccentricity": Effect(WHEELS, "amplitude", "m", (2e-4, 8e-4), 3e-4),
    "radius_vs_speed": Effect(WHEELS, "slope", "1/(m/s)", (0.008, 0.02), 0.02),
    "radius_step": Effect(WHEELS, "ratio", "1", (0.003, 0.008), 0.005),
    "bump": Effect(WHEELS, "lost", "m", (1.5e-3, 4e-3), 2e-3),
    "slip_patch": Effect(WHEELS, "fraction", "1", (0.03, 0.1), 0.05),
    "traction_slip": Effect(WHEELS, "compliance", "s^2/m", (0.05, 0.15), 0.05),
    "wheelbase": Effect(TRUCKS, "ratio", "1", (0.006, 0.02), 0.01),
    "turn_scrub": Effect(TRUCKS, "slope", "m", (0.005, 0.015), 0.005),
    "wheel_misalignment": Effect(TRUCKS, "angle", "rad", (0.004, 0.012), 0.005),
    "lateral_slip": Effect(TRUCKS, "compliance", "s", (0.02, 0.08), 0.02),
    "floor_slope": Effect(TRUCKS, "rate", "1", (0.004, 0.012), 0.005),
    "castor_kick": Effect(TRUCKS, "yaw", "rad", (0.01, 0.03), 0.01),
    "joint_bias": Effect(JOINTS, "bias", "rad", (0.004, 0.012), 0.005),
    "joint_eccentricity": Effect(JOINTS, "amplitude", "rad", (0.004, 0.012), 0.005),
    "joint_backlash": Effect(JOINTS, "width", "rad", (0.01, 0.03), 0.01),
    "link_bias": Effect(("link",), "bias", "m", (0.004, 0.012), 0.005),
    "link_eccentricity": Effect(("link",), "amplitude", "m", (0.003, 0.008), 0.003),
    "link_scale": Effect(("link",), "ratio", "1", (0.05, 0.15), 0.05),
    "count_loss": Effect(WHEELS, "fraction", "1", (0.004, 0.012), 0.01),
    "latency": Effect(JOINTS, "delay", "s", (0.03, 0.08), 0.02),
    "gear_backlash": Effect(WHEELS, "width", "m", (0.002, 0.006), 1e-3),
    "gear_harmonic": Effect(WHEELS, "amplitude", "m", (2e-4, 5e-4), 2e-4),
    "clock_drift": Effect(JOINTS, "rate", "1", (3e-4, 8e-4), 5e-4),
}
# Effects that act in both directions, beside those whose size is a ratio.
SIGNED = {"radius_vs_speed", "wheel_misalignment", "castor_kick", "joint_bias", "link_bias"}
WAVES = {"wheel_eccentricity", "joint_eccentricity", "link_eccentricity", "gear_harmonic"}  # have a phase
UNITS = {
    "phase": "rad", "order": "1", "time": "s", "times": "s", "above": "m/s", "direction": "rad",
}  # fmt: skip  # of parameters that are no size
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


def label(
    effect: str,
    component: str,
    parameters: Mapping[str, Any],
    acceptable: Iterable[tuple[str, str]] | None = None,
    intervals: list[list[float]] | None = None,
) -> dict[str, Any]:
    """Return the label of one effect, or of "unknown", as `labels.json` holds it.

    `acceptable` are other effects that count as right, by (effect, component), those of `ALIKE` for None;
    `intervals` [s] those in which it acts, for None those of its parameters.
    """
    if intervals is None:
        intervals = parameters.get("intervals", [])
        if effect == "bump":
            intervals = [[time, time + 0.3] for time in parameters["times"]]
    units = UNITS if effect == "unknown" else UNITS | {VOCABULARY[effect].parameter: VOCABULARY[effect].unit}
    return {
        "effect": effect,
        "component": component,
        "parameters": {
            name: {"value": value, "unit": units[name]}
            for name, value in parameters.items()
            if name != "intervals" and effect != "unknown"
        },
        "intervals": intervals,
        "acceptable": [
            {"effect": other, "component": place, "by_judgement": True}
            for other, place in (_alike(effect, component) if acceptable is None else acceptable)
        ],
    }


CLEAR = 5.0  # standard deviations below which a recording may not show something


def case_label(kind: str, effects: list[dict[str, Any]], *, weak: bool) -> dict[str, Any]:
    """Return what the label of a case of one recording says; any answer is right where an effect is weak."""
    verdict = (
        ["insufficient", "agreement", "mismatch"] if weak else ["mismatch"] if effects else ["agreement"]
    )
    kind = "insufficient" if weak else kind
    return {"kind": kind, "verdict": verdict, "recordings": ["1"], "effects": effects}


def set_bump_times(label: dict[str, Any], time: Array, counts: NDArray[np.int64]) -> None:
    """Set the times of a bump's label to when the wheel meets them: while it stands it meets none."""
    rolls = np.diff(counts) != 0
    begins, ends = time[:-1][rolls], time[1:][rolls]
    known = label["parameters"]["times"]
    at = np.searchsorted(ends, known["value"], side="right").clip(max=len(ends) - 1)
    known["value"] = np.maximum(known["value"], begins[at]).tolist()
    label["intervals"] = [[start, start + 0.3] for start in known["value"]]


def _alike(effect: str, component: str) -> Iterator[tuple[str, str]]:
    for other in ALIKE.get(effect, ()):
        places = VOCABULARY[other].components
        if component in places:
            yield other, component
        elif other.startswith("joint_") and component in TRUCKS:
            yield other, f"joint_{component}"
        elif places == TRUCKS:
            yield other, component.removeprefix("joint_")[:1]
        elif other == "gear_backlash":
            yield from ((other, f"{component}.left"), (other, f"{component}.right"))
