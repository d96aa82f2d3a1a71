"""How long a diagnosis against the whole library takes, how much memory, and how both grow with the length.

    python -m benchmarks.diagnose_speed [--samples 20000] [--doublings 2]

Each length in a process of its own, in which a short drive was diagnosed before: nothing is compiled.
"""

import argparse
import resource
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

from rich.progress import track

from mismatch import diagnose
from motion.paths import figure_eight
from vcan_sim.effects import effect_named
from vcan_sim.reference import reference_vehicle
from vcan_sim.simulate import simulate
from vcan_sim.truth import Truth
from vehicle.recording import Recording

WORN = effect_named("wheel_diameter")("a.left", ratio=1.004), effect_named("joint_bias")("joint_a", bias=0.01)


def recorded(samples: int) -> Recording:
    """Return a drive of at least so many samples, of a robot with a worn wheel and a joint that is off."""
    vehicle = reference_vehicle()
    laps = 1
    while True:
        recording = simulate(vehicle, Truth(vehicle, seed=7, effects=WORN), figure_eight(1.0, laps))
        if len(recording) >= samples:
            return recording
        laps = 1 + laps * samples // len(recording)


def measured(samples: int) -> tuple[int, float, float, str]:
    """Return samples, seconds, peak memory [MiB] and the first finding of one diagnosis."""
    diagnose([recorded(2000)])
    recording = recorded(samples)
    began = time.perf_counter()
    found = diagnose([recording])
    seconds = time.perf_counter() - began
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    return (
        len(recording),
        seconds,
        memory,
        ", ".join(f"{one.effect} {one.component}" for one in found.findings),
    )


def main() -> None:
    """Print a line for every length."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--samples", type=int, default=20_000)
    parser.add_argument("--doublings", type=int, default=2)
    options = parser.parse_args()
    lengths = [options.samples * 2**number for number in range(options.doublings + 1)]
    with ProcessPoolExecutor(1, mp_context=get_context("spawn"), max_tasks_per_child=1) as pool:
        lines = list(track(pool.map(measured, lengths), "diagnosing", total=len(lengths)))
    for samples, seconds, memory, found in lines:
        print(f"{samples} samples: {seconds:.1f} s, {memory:.0f} MiB at most: {found}")


if __name__ == "__main__":
    main()
