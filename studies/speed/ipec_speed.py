"""The processor time of a live step, and of an hour of recording, through IPEC, filter and smoother.

Peer: plain odometry of both trucks over the same samples.

Usage: python -m studies.speed.ipec_speed [hours]
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import numpy as np

from omnimate.ipec.corrector import Corrector, correct
from omnimate.ipec.filter.estimate import estimate
from omnimate.ipec.filter.live import Filter
from omnimate.ipec.filter.smoother import smooth
from omnimate.motion.paths import rounded_rectangle
from omnimate.vcan_sim.floor import Floor
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.odometry import Odometer, dead_reckon
from omnimate.vehicle.parameters import VehicleParameters
from omnimate.vehicle.recording import Direction, Recording
from omnimate.vehicle.sample import Sample
from omnimate.vehicle.se2 import Array
from studies.benchmark import best, options

STEPS = 20_000
ROUNDS = 5  # the best counts: the machine may be shared
LAP = 68.0  # [s]


def drive(hours: float) -> Recording:
    vehicle = reference_vehicle()
    pair: list[Direction] = ["cw", "ccw"]
    laps = max(2, round(hours * 3600.0 / LAP))
    return simulate(
        vehicle, Truth(vehicle, floor=Floor()), rounded_rectangle(6.0, 3.25, (pair * laps)[:laps])
    )


def samples(recording: Recording, count: int) -> list[Sample]:
    nan = (float("nan"),) * 7
    rows = zip(recording.counts[:count].tolist(), recording.present[:count].tolist(), strict=True)
    return [Sample(k, 0.015 * k, tuple(row), tuple(seen), nan, nan) for k, (row, seen) in enumerate(rows)]


def plain_step(vehicle: VehicleParameters, stream: list[Sample]) -> float:
    """Return the processor time of one step of plain odometry of both trucks [us]."""

    def steps() -> None:
        odometers = [Odometer(vehicle, truck) for truck in vehicle.trucks]
        for sample in stream:
            for odometer in odometers:
                odometer.step(sample)

    return best(steps, ROUNDS, time.process_time) / len(stream) * 1e6


def plain(recording: Recording) -> list[Array]:
    """Return the paths of both trucks by plain odometry."""
    return [dead_reckon(recording, truck) for truck in recording.vehicle.trucks]


def live(method: Corrector | Filter, stream: list[Sample]) -> float:
    """Return the processor time of one step of a method [us]."""

    def steps() -> None:
        state = method.start()
        for sample in stream:
            state = method.step(state, sample)  # type: ignore[arg-type]  # a method's own state

    return best(steps, ROUNDS, time.process_time) / len(stream) * 1e6


def hour(work: Callable[[], object]) -> float:
    """Return the best processor time of some rounds [s]; the first one, which compiles, does not count."""
    work()
    return best(work, ROUNDS, time.process_time)


def main() -> int:
    recording = drive(options(__doc__, {"hours": 1.0}).hours)
    vehicle, stream = recording.vehicle, samples(recording, STEPS)
    hours = len(recording) * vehicle.bus.sync_period / 3600.0
    steps: dict[str, tuple[Corrector | Filter, float]] = {
        "IPEC": (Corrector(vehicle), 20.0),
        "filter": (Filter(vehicle), 20.0),
    }
    within = True
    odometry = plain_step(vehicle, stream)
    print(f"live step, {'odometry':<8} {odometry:8.1f} us")
    for name, (method, wanted) in steps.items():
        cost = live(method, stream)
        within &= cost < wanted
        ratio = cost / odometry
        print(f"live step, {name:<8} {cost:8.1f} us   {ratio:5.1f} times   (wanted: below {wanted:.0f} us)")
    loops = {"IPEC": (correct, 0.2), "filter": (estimate, 2.0), "smoother": (smooth, 2.0)}
    odometry = hour(lambda: plain(recording)) / hours
    print(f"an hour through  odometry {odometry:8.3f} s")
    for name, (work, wanted) in loops.items():
        cost = hour(lambda work=work: work(recording)) / hours  # type: ignore[misc]  # a default binds it
        within &= cost < wanted
        ratio = cost / odometry
        print(f"an hour through  {name:<8} {cost:8.3f} s    {ratio:5.1f} times   (wanted: below {wanted} s)")
    print(f"{len(recording)} samples, {np.sum(np.diff(recording.counts[:, 0]) != 0)} of them in motion")
    return 0 if within else 1


if __name__ == "__main__":
    sys.exit(main())
