"""What a finding is called among engineers: sentences, regimes, and the drives that tell effects apart."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterable

    from omnimate.effects.effect import Effect
    from omnimate.vehicle.parameters import VehicleParameters

REGIMES = {
    "wheel_diameter": "in proportion to the way rolled",
    "wheel_eccentricity": "wheel angle of {component}",
    "radius_vs_speed": "speed of {component}",
    "radius_step": "from one moment on",
    "bump": "at single moments",
    "slip_patch": "on one stretch",
    "traction_slip": "accelerating and braking",
    "wheelbase": "turning",
    "turn_scrub": "turning, by curvature",
    "wheel_misalignment": "in proportion to the way driven",
    "lateral_slip": "turning, by speed times yaw rate",
    "floor_slope": "heading on the floor",
    "castor_kick": "at reversals of travel",
    "joint_bias": "always",
    "joint_eccentricity": "angle of {component}",
    "joint_backlash": "at reversals of {component}",
    "link_bias": "always",
    "link_eccentricity": "angle of joint_a",
    "link_scale": "link length",
    "count_loss": "speed of {component}",
    "latency": "in proportion to the rate of {component}",
    "gear_backlash": "at reversals of {component}",
    "gear_harmonic": "wheel angle of {component}, order {order:g}",
    "clock_drift": "time",
}

_TELLS = {
    "wheel_diameter": "long straights with the heading measured at both ends",
    "wheel_eccentricity": "a slow straight of twenty wheel turns",
    "radius_vs_speed": "the same straight at two speeds",
    "radius_step": "the same lap before and after the moment",
    "traction_slip": "hard starts and stops on a straight",
    "wheelbase": "turns on the spot in both directions with the heading measured",
    "turn_scrub": "arcs of two radii, and a turn on the spot",
    "wheel_misalignment": "a straight with absolute headings and positions of the truck measured",
    "lateral_slip": "the same arc at two speeds",
    "floor_slope": "the same straight in four directions of the floor, with absolute poses",
    "castor_kick": "ten reversals on one straight",
    "joint_bias": "a straight with the headings of both trucks measured from outside",
    "joint_eccentricity": "car-like turns that take the joint through a wide range of angles",
    "joint_backlash": "a slalom that reverses the joint often",
    "link_bias": "car-like turns in both directions with the joints at large angles",
    "link_eccentricity": "car-like turns that take joint_a through a wide range of angles",
    "link_scale": "a drive that moves the slider over its stroke",
    "count_loss": "the same straight slowly and at full speed",
    "latency": "a slalom with quick changes of the turn rate",
    "gear_backlash": "ten reversals on one straight",
    "gear_harmonic": "a slow straight of twenty wheel turns",
    "clock_drift": "a drive three times as long",
    "bump": "the same path again: what lies on the floor is met again at the same place",
    "slip_patch": "the same path again: a patch of the floor is met again at the same place",
}


def part(component: str) -> str:
    """Return what an engineer calls a component."""
    if "." in component:
        truck, side = component.split(".")
        return f"the {side} wheel of truck {truck}"
    return {
        "a": "truck a",
        "b": "truck b",
        "joint_a": "the encoder of joint a",
        "joint_b": "the encoder of joint b",
        "link": "the linear encoder of the link",
        "poses": "the measurement of absolute poses",
        "left": "both left wheels",
        "right": "both right wheels",
    }.get(component, component)


def regime(effect: Effect) -> str:
    """Return in which regime of the drive an effect shows."""
    return REGIMES[effect.name].format(component=effect.component, order=getattr(effect, "order", 1.0))


def sentence(effect: Effect, vehicle: VehicleParameters) -> str:
    """Return a finding in a sentence."""
    build = _SENTENCES[effect.name]
    text: str = (
        build(effect, vehicle)
        if callable(build)
        else build.format(part=part(effect.component), **_shown(effect))
    )
    return text[0].upper() + text[1:]


def _shown(effect: Effect) -> dict[str, Any]:
    """Return the parameters in the units of a shop floor."""
    shown: dict[str, Any] = {}
    for spec in effect.parameters:
        value = getattr(effect, spec.name)
        if isinstance(value, tuple):
            continue
        factor = {"m": 1e3, "rad": math.degrees(1.0), "s": 1.0}.get(spec.unit, 1.0)
        shown[spec.name] = value * factor
        shown[f"{spec.name}_percent"] = (value - 1.0) * 100.0
        shown[f"{spec.name}_hundredths"] = value * 100.0
    return shown


def _diameter(effect: Effect, vehicle: VehicleParameters) -> str:
    ratio = effect.values()["ratio"]
    nominal = 1e3 * vehicle.wheel_diameter(effect.component)  # type: ignore[arg-type]
    return (
        f"{part(effect.component)} rolls {abs(ratio - 1.0) * 100.0:.3f} % "
        f"{'more' if ratio > 1.0 else 'less'} per turn than vehicle.toml says: "
        f"its diameter is {ratio * nominal:.3f} mm, not {nominal:.3f} mm."
    )


def _wheelbase(effect: Effect, vehicle: VehicleParameters) -> str:
    ratio = effect.values()["ratio"]
    nominal = 1e3 * vehicle.trucks[effect.component].wheelbase  # type: ignore[index]
    return (
        f"{part(effect.component)} turns as if its wheelbase were {ratio * nominal:.2f} mm, "
        f"not {nominal:.2f} mm ({(ratio - 1.0) * 100.0:+.2f} %)."
    )


def _bump(effect: Effect, _vehicle: VehicleParameters) -> str:
    lost = [1e3 * one for one in effect.values()["lost"]]
    many = f"{len(lost)} bumps" if len(lost) > 1 else "a bump"
    return (
        f"{part(effect.component)} went over {many}: each time it rolled about "
        f"{sum(lost) / max(len(lost), 1):.2f} mm that the truck did not travel."
    )


def _patch(effect: Effect, _vehicle: VehicleParameters) -> str:
    start, end = effect.values()["intervals"][0]
    return (
        f"{part(effect.component)} slipped for {end - start:.1f} s: "
        f"{100.0 * effect.values()['fraction']:.1f} % of what it rolled was not travelled."
    )


def _slope(effect: Effect, _vehicle: VehicleParameters) -> str:
    values = effect.values()
    towards = f"towards {math.degrees(values['direction']):.0f} degrees of the floor"
    if values["pace"]:
        creep = 1e3 * values["rate"] * values["pace"]
        return (
            f"{part(effect.component)} creeps at {creep:.2f} mm/s {towards}, also where it stands: "
            "it slopes, under tyres or a film that give way."
        )
    return f"{part(effect.component)} creeps {100.0 * values['rate']:.3f} % of its way {towards}: it slopes."


_SENTENCES: dict[str, Any] = {
    "wheel_diameter": _diameter,
    "wheelbase": _wheelbase,
    "bump": _bump,
    "slip_patch": _patch,
    "wheel_eccentricity": (
        "{part} runs out of round by {amplitude:.3f} mm: once per turn of that wheel the truck yaws."
    ),
    "radius_vs_speed": (
        "{part} changes its rolling radius with speed, by {slope_hundredths:.3f} % for each m/s."
    ),
    "radius_step": (
        "{part} changes its rolling radius at one moment, by {ratio_percent:+.3f} %: "
        "a load moved or a tyre lost air."
    ),
    "traction_slip": "{part} slips in proportion to its acceleration (compliance {compliance:.4g} s^2/m).",
    "turn_scrub": (
        "{part} scrubs in turns: its wheelbase grows by {slope_hundredths:.2f} % per 1/m of curvature."
    ),
    "wheel_misalignment": (
        "the axle of {part} is turned by {angle:+.3f} degrees: "
        "it travels at that angle to its own straight ahead."
    ),
    "lateral_slip": "{part} creeps outwards in turns (compliance {compliance:.4g} s).",
    "floor_slope": _slope,
    "castor_kick": ("{part} yaws by {yaw:+.3f} degrees each time it reverses: its castors swing round."),
    "joint_bias": "{part} reads {bias:+.3f} degrees too much, all the time.",
    "joint_eccentricity": (
        "{part} errs by {amplitude:.3f} degrees once per turn of the joint: its disc is mounted off centre."
    ),
    "joint_backlash": ("{part} lags by a play of {width:.3f} degrees when the joint reverses."),
    "link_bias": "{part} reads {bias:+.2f} mm too much, all the time.",
    "link_eccentricity": "{part} errs by {amplitude:.2f} mm with the angle of joint a.",
    "link_scale": "{part} has a scale that is wrong by {ratio_percent:+.3f} %.",
    "count_loss": "{part} loses {fraction_hundredths:.2f} % of its counts while faster than {above:.3g} m/s.",
    "latency": "{part} sends samples that are {delay:.4f} s old.",
    "gear_backlash": ("{part} stands still through a play of {width:.2f} mm each time its motor reverses."),
    "gear_harmonic": "{part} beats {order:g} times per turn, by {amplitude:.3f} mm: a gear or a belt.",
    "clock_drift": "the clock of {part} runs off by {rate_hundredths:.4f} %.",
}


def separating(effects: Iterable[str]) -> str:
    """Return the drives that would tell effects apart."""
    drives = list(dict.fromkeys(_TELLS[one] for one in effects if one in _TELLS))
    return "; ".join(drives)


def drives_for(effects: Iterable[str]) -> tuple[str, ...]:
    """Return one drive for each effect that would show it."""
    return tuple(dict.fromkeys(_TELLS[one] for one in effects if one in _TELLS))
