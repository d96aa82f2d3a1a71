"""Parameters that the filter estimated during a drive, with advice on its findings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from omnimate.calib.advice import Advice
from omnimate.calib.linkage.calibration import without_biases
from omnimate.vehicle.parameters import JOINTS, WHEELS, Truck

if TYPE_CHECKING:
    from omnimate.ipec.filter.findings import Findings, SlowParameters
    from omnimate.vehicle.parameters import TruckName, VehicleParameters

Unit = Literal["m", "s", "rad"]
SCALE_ADVICE = Advice(
    "note",
    "encoders alone cannot tell the mean diameter of all wheels, nor a floor that makes both trucks creep",
    "measure a straight of some metres, or record absolute poses (fixes)",
)


@dataclass(frozen=True, slots=True)
class LearnedValue:
    """A parameter that the filter estimated."""

    name: str
    unit: Unit
    described: float  # nominal value
    value: float  # estimated value
    sigma: float  # standard deviation


def learned_values(vehicle: VehicleParameters, slow: SlowParameters) -> tuple[LearnedValue, ...]:
    """Return diameters, wheelbases, creep and biases, in the order of `SlowParameters.vector`."""
    described: list[tuple[str, Unit, float]] = []
    for name, truck in vehicle.trucks.items():
        described.append((f"{name}.left diameter", "m", truck.wheel_diameter_left))
        described.append((f"{name}.right diameter", "m", truck.wheel_diameter_right))
    described += [(f"{name} wheelbase", "m", truck.wheelbase) for name, truck in vehicle.trucks.items()]
    described += [(f"{name} sideways creep", "s", 0.0) for name in vehicle.trucks]
    described += [(f"{joint} bias", "rad", 0.0) for joint in JOINTS]
    described += [("link bias", "m", 0.0)]
    learned = zip(described, slow.vector.tolist(), slow.sigma.tolist(), strict=True)
    return tuple(
        LearnedValue(name, unit, value, value * (1.0 + by) if value else by, (value or 1.0) * sigma)
        for (name, unit, value), by, sigma in learned
    )


def learned_vehicle(
    vehicle: VehicleParameters, slow: SlowParameters, findings: Findings
) -> VehicleParameters:
    """Return the robot with the parameters that the filter estimated, except those that are undecided.

    Creep is no parameter of `vehicle.toml`. A joint bias may also be an axle turned in its truck: encoders
    cannot distinguish them. The path is the same, the heading of the body is not.
    """
    undecided = {name for name, _ in findings.undecided}

    def taken(name: str, value: float) -> float:
        return 0.0 if name in undecided else value

    trucks: dict[TruckName, Truck] = {}
    for number, name in enumerate(vehicle.trucks):
        truck, (left, right) = vehicle.trucks[name], slow.wheel[2 * number : 2 * number + 2].tolist()
        wider = taken(f"wheelbase of {name}", float(slow.wheelbase[number]))
        trucks[name] = Truck(
            wheelbase=truck.wheelbase * (1.0 + wider),
            wheel_diameter_left=truck.wheel_diameter_left * (1.0 + taken(f"diameters of {name}", left)),
            wheel_diameter_right=truck.wheel_diameter_right * (1.0 + taken(f"diameters of {name}", right)),
        )
    biases = slow.joint_bias.tolist()
    joint_a, joint_b = (taken(f"bias of {joint}", bias) for joint, bias in zip(JOINTS, biases, strict=True))
    return without_biases(vehicle, trucks, (joint_a, joint_b), taken("bias of link", slow.link_bias))


def advice_of(findings: Findings) -> tuple[Advice, ...]:
    """Return advice on wrong values, contradictions of the model, and unidentified parameters."""
    wrong = [
        Advice(
            "warning",
            f"vehicle.toml is probably wrong (probability {probability:.2f}): {name}",
            f"take over its learned value{_ambiguity(name)}",
        )
        for name, probability in findings.suspects
        if (name, probability) not in findings.undecided
    ]
    wrong += _undecided(findings.undecided)
    wrong += [
        Advice(
            "warning",
            f"the model is contradicted (probability {probability:.2f}): {name} read more than "
            f"{'a travel' if name in WHEELS else 'an angle and a bias'}",
            "look for a late reading, and for slip while it speeds up and brakes"
            if name in WHEELS
            else "look for play, eccentricity, a late reading",
        )
        for name, probability in findings.misread
    ]
    wrong += [
        Advice(
            "warning",
            f"the model is contradicted: the {name} scatter {factor:.0f} times as much as on an ordinary "
            "floor",
            "look for loose parts, slip, and a rough floor",
        )
        for name, factor in findings.scatter
    ]
    return (*wrong, *_unidentified(findings.untold), SCALE_ADVICE)


def _undecided(values: tuple[tuple[str, float], ...]) -> list[Advice]:
    """Return advice on values that may be wrong or not; none where there are none."""
    if not values:
        return []
    named = ", ".join(f"{name} ({probability:.2f})" for name, probability in values)
    return [
        Advice(
            "warning" if sum(probability for _, probability in values) >= 0.5 else "note",
            f"the encoders do not tell which of these is wrong (probability): {named}",
            "drive bends to both sides in which both joints turn, or record absolute poses (fixes); until "
            "then these values stay as they are",
        )
    ]


def _ambiguity(name: str) -> str:
    """Return an alternative explanation of a suspect, with a remedy; empty for none."""
    if name.startswith("bias of joint"):
        return "; an axle that is turned in its truck looks the same: only poses of the truck tell them apart"
    if name.startswith("diameters"):
        return "; the mean of all wheels is not known: measure a straight of some metres"
    return ""


def _unidentified(names: tuple[str, ...]) -> list[Advice]:
    """Return advice on drives that identify the remaining parameters."""
    drives = {
        "drive straight for some metres": [name for name in names if name.startswith("unequal")],
        "drive rounded corners to both sides with a short radius": [
            name for name in names if not name.startswith("unequal")
        ],
    }
    return [
        Advice("note", f"this drive does not tell whether these are wrong: {', '.join(open_)}", do)
        for do, open_ in drives.items()
        if open_
    ]
