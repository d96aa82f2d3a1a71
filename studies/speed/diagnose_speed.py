"""The time and memory of a diagnosis against the whole library, and how both grow with the length of a drive.

Peer: the simulation of the same drive, in the same process.

Usage: python -m studies.speed.diagnose_speed [--samples 20000] [--doublings 2]

Each length has a process of its own, in which a short drive is diagnosed first, so that nothing is compiled
while the time is measured. For 20,000 samples 2 s of one processor and 500 MiB are wanted.
"""

import resource
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

from rich.progress import track

from omnimate.effects.joint_bias import JointBias
from omnimate.effects.wheel_diameter import WheelDiameter
from omnimate.mismatch import diagnose
from omnimate.motion.paths import figure_eight
from omnimate.vcan_sim.reference import reference_vehicle
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.recording import Recording
from studies.benchmark import cost, duration, options

WORN = WheelDiameter("a.left", ratio=1.004), JointBias("joint_a", bias=0.01)


def simulated(laps: int) -> Recording:
    """Return a drive of a robot with a worn wheel and a biased joint."""
    vehicle = reference_vehicle()
    return simulate(vehicle, Truth(vehicle, seed=7, effects=WORN), figure_eight(1.0, laps))


def measured(samples: int) -> str:
    """Return the figures of a drive of at least so many samples, as a line."""
    lap = simulated(1)
    diagnose([lap])
    laps = 1 + samples // len(lap)
    simulation = duration(lambda: simulated(laps))
    recording, diagnoses = simulated(laps), []
    used = cost(lambda: diagnoses.append(diagnose([recording])))
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    findings = ", ".join(f"{finding.effect} {finding.component}" for finding in diagnoses[0].findings)
    return (
        f"{len(recording)} samples: {used.wall:.1f} s (processor {used.processor:.1f} s), "
        f"{used.wall / simulation:.0f} times the simulation of the drive, {memory:.0f} MiB at most: "
        f"{findings}"
    )


def main() -> None:
    given = options(__doc__, samples=20_000, doublings=2)
    lengths = [given.samples * 2**number for number in range(given.doublings + 1)]
    with ProcessPoolExecutor(1, mp_context=get_context("spawn"), max_tasks_per_child=1) as pool:
        lines = list(track(pool.map(measured, lengths), "diagnosing", total=len(lengths)))
    print(*lines, sep="\n")


if __name__ == "__main__":
    main()
