"""The time of the quick question of `diagnose --triage`, alone and as a whole process.

Peers, in the same run: the whole diagnosis and the simulation of the same drive, and an empty Python.

Usage: python -m studies.speed.triage_speed [--samples 20000] [rounds]

The best of several rounds counts, because the machine may be shared; 0.3 s are wanted for 20,000 samples.
The processor time beside it says what the question itself costs.
"""

import argparse
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from omnimate.files.recordings.folder import save_recording
from omnimate.mismatch import diagnose
from omnimate.mismatch.triage.triage import triage
from studies.speed.diagnose_speed import simulated

WANTED = 0.3  # [s]


def best(call: Callable[[], object], rounds: int, clock: Callable[[], float] = time.perf_counter) -> float:
    """Return the shortest time of several calls [s]."""
    times = []
    for _ in range(rounds):
        began = clock()
        call()
        times.append(clock() - began)
    return min(times)


def main() -> None:
    """Print the times and their ratios."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--samples", type=int, default=20_000)
    parser.add_argument("rounds", type=int, nargs="?", default=7)
    options = parser.parse_args()
    lap = simulated(1)
    triage([lap])
    diagnose([lap])
    laps = 1 + options.samples // len(lap)
    simulation = best(lambda: simulated(laps), 1)
    recording = simulated(laps)
    asked = best(lambda: triage([recording]), options.rounds)
    used = best(lambda: triage([recording]), options.rounds, time.process_time)
    whole = best(lambda: diagnose([recording]), 1)
    command = [sys.executable, "-m", "omnimate.cli.main", "diagnose", "--triage"]
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "drive"
        save_recording(recording, folder)
        process = best(
            lambda: subprocess.run([*command, str(folder)], check=True, capture_output=True), options.rounds
        )
        empty = best(lambda: subprocess.run([sys.executable, "-c", "pass"], check=True), options.rounds)
    print(
        f"{len(recording)} samples, {recording.time[-1] - recording.time[0]:.0f} s of driving: "
        f"triage {asked:.2f} s (wanted {WANTED}; processor {used:.2f} s), "
        f"{asked / whole:.3f} of the whole diagnosis, "
        f"{asked / simulation:.2f} of the simulation of the drive; "
        f"as a process, with reading the log, {process:.2f} s (an empty Python {empty:.2f} s)"
    )
    sys.exit(asked > WANTED)


if __name__ == "__main__":
    main()
