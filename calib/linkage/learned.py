"""What the filter has learned of a robot while it drove: its values, what contradicts them, what is open."""

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
SCALE = Advice(
    "note",
    "encoders alone cannot tell the mean diameter of all wheels, nor a floor that makes both trucks creep",
    "measure a straight of some metres, or record absolute poses (fixes)",
)


@dataclass(frozen=True, slots=True)
class LearnedValue:
    """A value that the filter has learned.

    Attributes:
        name: What it is of the robot.
        unit: Its unit.
        described: The value by which the robot drove.
        value: The value that was learned.
        sigma: Its standard deviation.
    """

    name: str
    unit: Unit
    described: float
    value: float
    sigma: float


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


def learned_vehicle(vehicle: VehicleParameters, slow: SlowParameters) -> VehicleParameters:
    """Return the same robot with what the filter has learned of its encoders while it drove.

    Creep is no parameter of a robot and stays. A bias of a joint may also be an axle that is turned in its
    truck: encoders cannot tell; the path is the same, the heading of the body is not.
    """
    trucks: dict[TruckName, Truck] = {}
    for number, name in enumerate(vehicle.trucks):
        truck, (left, right) = vehicle.trucks[name], slow.wheel[2 * number : 2 * number + 2].tolist()
        trucks[name] = Truck(
            wheelbase=truck.wheelbase * (1.0 + float(slow.wheelbase[number])),
            wheel_diameter_left=truck.wheel_diameter_left * (1.0 + left),
            wheel_diameter_right=truck.wheel_diameter_right * (1.0 + right),
        )
    joint_a, joint_b = slow.joint_bias.tolist()
    return without_biases(vehicle, trucks, (joint_a, joint_b), slow.link_bias)


def advice_of(said: Findings) -> tuple[Advice, ...]:
    """Return what contradicts vehicle.toml or the model, what is not told yet, and what to do about it."""
    wrong = [
        Advice(
            "warning",
            f"vehicle.toml is probably wrong (probability {probability:.2f}): {name}",
            f"take over its learned value{_doubt(name)}",
        )
        for name, probability in said.suspects
    ]
    wrong += [
        Advice(
            "warning",
            f"the model is contradicted (probability {probability:.2f}): {name} read more than "
            f"{'a travel' if name in WHEELS else 'an angle and a bias'}",
            "look for a late reading, and for slip while it speeds up and brakes"
            if name in WHEELS
            else "look for play, eccentricity, a late reading",
        )
        for name, probability in said.misread
    ]
    wrong += [
        Advice(
            "warning",
            f"the model is contradicted: the {name} scatter {factor:.0f} times as much as on an ordinary "
            "floor",
            "look for loose parts, slip, and a rough floor",
        )
        for name, factor in said.scatter
    ]
    return (*wrong, *_untold(said.untold), SCALE)


def _doubt(name: str) -> str:
    """Return what encoders alone cannot tell of a suspect, and what to do."""
    if name.startswith("bias of joint"):
        return "; an axle that is turned in its truck looks the same: only poses of the truck tell them apart"
    if name.startswith("both diameters"):
        return "; if it is the other truck, the scale is wrong: measure a straight of some metres"
    return ""


def _untold(names: tuple[str, ...]) -> list[Advice]:
    """Return what this drive has not told, and what to drive."""
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
