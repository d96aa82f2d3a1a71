"""A session with its faults, drawn from a seed, and the shortest part of it that still fails."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from random import Random
from typing import Literal

from omnimate.vcan_sim.faults import FAULTS, DeviceFault
from omnimate.vcan_sim.reference import reference_single, reference_vehicle
from omnimate.vehicle.parameters import VehicleParameters

ROBOTS: dict[str, Callable[[], VehicleParameters]] = {"single": reference_single, "double": reference_vehicle}
DEVICE_FAULTS: dict[str, type[DeviceFault]] = {fault.name: fault for fault in FAULTS}
NMT_COMMANDS = {"nmt stop": 0x02, "nmt pre-operational": 0x80, "nmt reset": 0x81, "nmt communication": 0x82}
NODE_FAULTS = (*DEVICE_FAULTS, *NMT_COMMANDS, "trip", "twin")
BUS_FAULTS = ("adapter", "power", "burst", "loss", "sync")
INSTANT = frozenset({*NMT_COMMANDS, "trip"})
LENGTH = 120.0  # [s] of a session
QUIET = 30.0  # [s] at its end without a fault, in which everything must come back
LONGEST = 4.0  # [s] of a fault


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault.

    Attributes:
        kind: One of `NODE_FAULTS` or `BUS_FAULTS`: the adapter is away, with the power of the devices too;
            frames come in a late burst, or some are lost; another device sends SYNC.
        at: When it begins, after the start of the session [s].
        duration: How long it lasts [s].
        node: Node that it is of; 0 for the bus.
    """

    kind: str
    at: float
    duration: float = 0.0
    node: int = 0


@dataclass(frozen=True, slots=True)
class Script:
    """A session: a robot, the seed of its commands and lost frames, and its faults in order of time."""

    robot: Literal["single", "double"]
    seed: int
    faults: tuple[Fault, ...]
    length: float = LENGTH


def draw(seed: int, number: int) -> Script:
    """Return session `number` of a seed."""
    random = Random(f"{seed} {number}")
    robot: Literal["single", "double"] = "double" if random.random() < 0.25 else "single"
    vehicle = ROBOTS[robot]()
    encoders = [encoder.node for encoder in vehicle.encoders]
    drives = [drive.node for drive in vehicle.drives]
    faults: list[Fault] = []
    for _ in range(random.randint(3, 12)):
        when = random.random()
        if when < 0.15:
            at = random.uniform(0.0, 0.6)  # in the middle of configuration
        elif when < 0.45 and faults:
            at = faults[-1].at + random.uniform(0.0, 1.5)  # at once with the last, or in its recovery
        else:
            at = random.uniform(0.6, LENGTH - QUIET - LONGEST)
        kind = random.choice(NODE_FAULTS if random.random() < 0.75 else BUS_FAULTS)
        nodes = drives if kind == "trip" else encoders if kind in {"frozen", "length"} else encoders + drives
        node = 0 if kind in BUS_FAULTS else random.choice(nodes)
        duration = 0.0 if kind in INSTANT else 10.0 ** random.uniform(-2.0, 0.6)
        faults.append(Fault(kind, round(at, 3), round(duration, 3), node))
    return Script(robot, random.randrange(1000), tuple(sorted(faults, key=lambda fault: fault.at)))


def shrink(script: Script, fails: Callable[[Script], bool]) -> Script:
    """Return a script that fails, too, and no longer does without any one of its faults."""
    number = 0
    while number < len(script.faults):
        shorter = replace(script, faults=script.faults[:number] + script.faults[number + 1 :])
        if fails(shorter):
            script, number = shorter, 0
        else:
            number += 1
    return script
