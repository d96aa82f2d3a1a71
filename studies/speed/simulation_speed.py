"""The speed of a simulation without a bus, and the time of a live step of runner and plant.

Peer: the same robot stepped live, sample by sample, as on a bus.

Usage: python -m studies.speed.simulation_speed
"""

from __future__ import annotations

import sys
from collections.abc import Callable

from omnimate.motion.paths import umbmark
from omnimate.motion.runner import Runner
from omnimate.vcan_sim.plant import Plant
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from studies.benchmark import best, duration, options

TARGET = 1000.0  # times real time
STEPS = 20_000


def step_cost(step: Callable[[], object]) -> float:
    """Return the time of one call [us]."""
    return best(lambda: [step() for _ in range(STEPS)]) / STEPS * 1e6


def main() -> int:
    options(__doc__)
    vehicle = reference_vehicle()
    assert vehicle.linkage is not None
    length = vehicle.linkage.length
    truth, program = Truth(vehicle), umbmark(link_length=length)
    first = duration(lambda: simulate(vehicle, truth, program))
    recording = simulate(vehicle, truth, program)
    driven = float(recording.time[-1] - recording.time[0])
    ratio = driven / best(lambda: simulate(vehicle, truth, program))
    runner, plant = Runner(program, vehicle), Plant(truth, vehicle)
    speeds = (1.0,) * len(vehicle.wheels)
    runner_cost = step_cost(lambda: runner.step((0.1, 0.0, 0.0), (0.0, 0.0, length)))
    plant_cost = step_cost(lambda: plant.step(speeds, vehicle.bus.sync_period))
    print(f"UMBmark, two trucks, {driven:.0f} s of driving, {len(recording)} samples")
    print(f"  first run, compiled or loaded  {first:8.2f} s")
    print(f"  after that                     {ratio:8.0f} times real time   (wanted: {TARGET:.0f} or more)")
    live = 1e6 * vehicle.bus.sync_period / (runner_cost + plant_cost)
    print(f"  step by step, as on a bus      {live:8.0f} times real time, {ratio / live:.1f} times slower")
    print(f"  Runner.step                    {runner_cost:8.2f} us")
    print(f"  Plant.step                     {plant_cost:8.2f} us")
    return 0 if ratio >= TARGET else 1


if __name__ == "__main__":
    sys.exit(main())
