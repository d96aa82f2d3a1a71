"""What may be concealed: effects, their sizes and components, and which of them a drive cannot separate."""

from __future__ import annotations

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
JOINTS = ("joint_a", "joint_b")
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
        return ("a.left", "a.right", "b.left", "b.right")
    if effect in OF_TRUCKS:
        return ("a", "b")
    if effect in OF_JOINTS:
        return JOINTS
    return JOINTS if effect in {"latency", "clock_drift"} else ("link",)
