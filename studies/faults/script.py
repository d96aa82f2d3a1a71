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
DISK_FAULTS = ("disk full", "torn write")
INSTANT = frozenset({*NMT_COMMANDS, "trip", "torn write"})
LENGTH = 120.0  # [s] of a session
QUIET = 30.0  # [s] at its end without a fault, in which everything must come back
LONGEST = 4.0  # [s] of a fault


@dataclass(frozen=True, slots=True)
class Fault:
    # one of `NODE_FAULTS`; of `BUS_FAULTS`: the adapter is away, with the power of the devices too; frames
    # come in a late burst, or some are lost; another device sends SYNC; of `DISK_FAULTS`: the disk takes
    # nothing; the driver's computer loses its power while blocks wait to be written
    kind: str
    at: float  # when it begins, after the start of the session [s]
    duration: float = 0.0  # how long it lasts [s]
    node: int = 0  # node that it is of; 0 for the bus or the disk

    def concerns(self, *nodes: int) -> bool:
        """Return whether what is seen at one of these nodes, 0 for the bus, may come from it."""
        if self.kind == "disk full":
            return False
        return self.node == 0 or self.node in nodes or self.kind == "babbling"


@dataclass(frozen=True, slots=True)
class Script:
    """A session: a robot, the seed of its commands and lost frames, and its faults in order of time."""

    robot: Literal["single", "double"]  # key of `ROBOTS`
    seed: int  # seed of commands, lost frames and torn blocks
    faults: tuple[Fault, ...]  # faults in order of time
    length: float = LENGTH  # length [s]
    # when the operator stops the robot, and enables its drives again or opens another driver [s]
    restarts: tuple[float, ...] = ()


def draw(seed: int, number: int) -> Script:
    """Return session `number` of a seed."""
    random = Random(f"{seed} {number}")
    robot: Literal["single", "double"] = "double" if random.random() < 0.25 else "single"
    vehicle = ROBOTS[robot]()
    encoders = [encoder.node for encoder in vehicle.encoders]
    drives = [drive.node for drive in vehicle.drives]
    last = LENGTH - QUIET - LONGEST
    restarts = tuple(sorted(round(random.uniform(5.0, last - 3.0), 3) for _ in range(random.randint(1, 4))))
    faults: list[Fault] = []
    for _ in range(random.randint(3, 12)):
        when = random.random()
        if when < 0.2:
            begins = (0.0, *restarts, *(at + 1.0 for at in restarts))  # the operator pauses for a second
            at = random.choice(begins) + random.uniform(0.01, 0.1)  # while nodes are configured
        elif when < 0.45:
            at = random.choice(restarts) + random.uniform(0.01, 0.15)  # while wheels run down
        elif when < 0.65 and faults:
            # at once with the last, or in its recovery
            at = min(faults[-1].at + random.uniform(0.0, 1.5), last)
        else:
            at = random.uniform(0.6, last)
        kind = random.choice(random.choices((NODE_FAULTS, BUS_FAULTS, DISK_FAULTS), (0.65, 0.2, 0.15))[0])
        nodes = drives if kind == "trip" else encoders if kind in {"frozen", "length"} else encoders + drives
        node = 0 if kind in {*BUS_FAULTS, *DISK_FAULTS} else random.choice(nodes)
        duration = 0.0 if kind in INSTANT else 10.0 ** random.uniform(-2.0, 0.6)
        faults.append(Fault(kind, round(at, 3), round(duration, 3), node))
    in_order = tuple(sorted(faults, key=lambda fault: fault.at))
    return Script(robot, random.randrange(1000), in_order, restarts=restarts)


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
